// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPages.h"

#include "pqApplicationCore.h"

#include <QHelpEngine>

void pqChainMailPages::startup()
{
  auto* core = pqApplicationCore::instance();
#if QT_VERSION >= QT_VERSION_CHECK(6, 0, 0)
  // Since Qt 6 a collection of pages takes no further ones unless somebody allows it, which ParaView 5.13 does not.
  core->helpEngine()->setReadOnly(false);
  core->helpEngine()->setupData();
#endif
  core->registerDocumentation(":/ChainMail/ChainMail.qch");
}
