# SPDX-License-Identifier: MIT
"""What both halves of the demonstration need: servos (demo.py) and displays (demo_screen.py)."""
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class Failure(Exception):
    pass


def run(command, **options):
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, **options)
    if done.returncode:
        raise Failure(f"{' '.join(command)}: exit code {done.returncode}\n"
                      f"{done.stdout}{done.stderr}")
    return done


class Directory:
    """build/demo/NAME"""

    def __init__(self, name):
        self.at = os.path.join(ROOT, "build/demo", name)
        os.makedirs(self.at, exist_ok=True)

    def path(self, name):
        return os.path.join(self.at, name)
