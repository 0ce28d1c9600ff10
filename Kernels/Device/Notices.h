#pragma once

#include <string>
#include <vector>

namespace chainmail
{

/// Stores a message for the user that is no error: a device or a folder that is not used. Each text is stored once in a
/// process. Any thread may call these functions at any time.
void giveNotice(const std::string& text);

/// The notices given since the last call.
std::vector<std::string> takeNotices();

}
