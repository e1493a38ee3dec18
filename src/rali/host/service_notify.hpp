#pragma once

#include <string>

namespace rali::host {

/// Tells systemd how the service does, where systemd has started it (NOTIFY_SOCKET): "READY=1",
/// "WATCHDOG=1", "STATUS=...", "STOPPING=1", one per line. Nothing happens elsewhere.
void notify_service(const std::string& lines);

}  // namespace rali::host
