// SPDX-License-Identifier: BSD-3-Clause
#ifndef ChainMailCompileAhead_h
#define ChainMailCompileAhead_h

/**
 * Has the kernels compiled that most scenes use, in a process of its own, while the user opens a scan. ParaView calls
 * it when it loads the plugin. Of several processes that compute together the first one does it, which is the one to
 * deform. Where the program is missing, there is no cache, or CHAINMAIL_COMPILE_AHEAD is 0 (Data/Install.md), nothing
 * happens, and the first update compiles what it needs.
 */
void ChainMailCompileAhead();

#endif
