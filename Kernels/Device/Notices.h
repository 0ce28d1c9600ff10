#pragma once

#include <string>
#include <vector>

namespace chainmail
{

/// Something that the person at the screen should hear of, though all goes on: a device or a folder that is not used.
/// The same text is kept once in a process. Any thread may call these functions at any time.
void giveNotice(const std::string& text);

/// The notices given since the last call.
std::vector<std::string> takeNotices();

}
