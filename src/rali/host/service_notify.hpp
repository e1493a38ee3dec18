#pragma once

#include <string>

namespace rali::host {

/// Reports the service state to systemd, if systemd has started it (NOTIFY_SOCKET): "READY=1",
/// "WATCHDOG=1", "STATUS=...", "STOPPING=1", one per line. Otherwise it does nothing.
void notify_service(const std::string& lines);

}  // namespace rali::host
