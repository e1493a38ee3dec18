#!/usr/bin/env python3
"""Runs a command and writes what it used: measured.py USAGE.json SECONDS COMMAND...

The peak memory that the kernel keeps of a process includes that of its parent before exec. This
launcher is small, so the figure is that of the command. Exit code: that of the command; 124 after
the limit, 128 + N after signal N.
"""

import json
import os
import signal
import sys


def main():
    usage_file, limit_s, command = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    pid = os.posix_spawnp(command[0], command, os.environ)
    late = []

    def stop(_signal, _frame):
        late.append(True)
        os.kill(pid, signal.SIGKILL)

    def interrupt(number, _frame):
        os.kill(pid, number)

    signal.signal(signal.SIGALRM, stop)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    signal.alarm(limit_s)
    _, status, used = os.wait4(pid, 0)
    signal.alarm(0)
    code = os.waitstatus_to_exitcode(status)
    if code < 0:
        code = 124 if late else 128 - code
    with open(usage_file, "w", encoding="utf-8") as file:
        json.dump({"exit": code, "cpu_s": used.ru_utime + used.ru_stime,
                   "memory_mb": used.ru_maxrss / 1024}, file)
    sys.exit(code)


if __name__ == "__main__":
    main()
