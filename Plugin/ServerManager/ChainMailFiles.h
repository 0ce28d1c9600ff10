// SPDX-License-Identifier: BSD-3-Clause
#ifndef ChainMailFiles_h
#define ChainMailFiles_h

/**
 * Where ParaView may not be able to read what it writes by default, lets it write VTK's XML files (.vti, .vtp, ...) in
 * a way that it can read. ParaView up to 5.12 hands the data behind the XML to the parser, too, which libexpat refuses
 * since 2.6, and in Debian 12 since 2.5.0-1+deb12u2. What the user has set as default stays, and so does what a dialog
 * or a script says. ParaView calls it when it loads the plugin.
 */
void ChainMailReadableFiles();

#endif
