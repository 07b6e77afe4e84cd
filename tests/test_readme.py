#!/usr/bin/env python3
"""What the README says works: its sh blocks run line by line, its C example compiles and runs against the
baked clip, every file it links to exists.
SPDX-License-Identifier: MIT
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MAIN = """
#include <stdio.h>
int start(void);
int32_t tick(uint32_t now_us);
int main(void)
{
    if (start() != 0) return 1;
    int32_t before = tick(0), after = tick(700000);
    printf("%ld %ld\\n", (long)before, (long)after);
    return before == after;
}
"""
passed = failed = 0


def check(what, good, detail=""):
    global passed, failed
    passed, failed = passed + good, failed + (not good)
    print("%s %s%s" % ("ok  " if good else "FAIL", what, "" if good else "\n" + detail))


def shell(command):
    done = subprocess.run(command, cwd=ROOT, shell=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.returncode == 0, done.stdout


with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as f:
    readme = f.read()
for line in "".join(re.findall(r"```sh\n(.*?)```", readme, re.S)).splitlines():
    check(line, *shell(line))
example = re.search(r"```c\n(.*?)```", readme, re.S).group(1)
work = os.path.join(ROOT, "build", "readme")
os.makedirs(work, exist_ok=True)
with open(os.path.join(work, "clip.h"), "w") as f:
    f.write('#include "../nod.h"\n')
with open(os.path.join(work, "example.c"), "w") as f:
    f.write(example + MAIN)
check("the C example", *shell("gcc -std=c99 -Wall -Wextra -Iinclude -Ifirmware/player/mem/near -Ibuild -Ibuild/readme "
                              "build/readme/example.c build/nod.c firmware/player/*.c firmware/player/kernel/plain/*.c -o build/readme/example && build/readme/example"))
for name in sorted(set(re.findall(r"\]\(([A-Za-z_/.]+)\)", readme))):
    check("link " + name, os.path.exists(os.path.join(ROOT, name)))
print("%d passed, %d failed" % (passed, failed))
sys.exit(failed != 0)
