// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailPages_h
#define pqChainMailPages_h

#include <QObject>

/// Hands the pages of this folder, which are in the plugin as a Qt resource, to ParaView's window of help, where the
/// button ? of the panel opens them.
class pqChainMailPages : public QObject
{
  Q_OBJECT

public:
  void startup();
  void shutdown() {}
};

#endif
