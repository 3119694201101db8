"""host/requirements.txt locks every wheel of LCM, and host/setup.sh says which Pythons those are for."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from core import ROOT

PYTHONS = ["3.10", "3.11", "3.12", "3.13", "3.14"]
MACHINES = ["aarch64", "x86_64"]


def check_python(answer):
    """Whether host/setup.sh goes on with a python3 that answers so, and what it says if not."""
    with tempfile.TemporaryDirectory() as scratch:
        python = pathlib.Path(scratch) / "python3"
        python.write_text(f"#!/bin/sh\necho {answer}\n")
        python.chmod(0o755)
        done = subprocess.run(["bash", "-c", f"source {ROOT}/host/setup.sh && _ssv_check_python"], capture_output=True, text=True,
                              env={"PATH": f"{scratch}:{os.environ['PATH']}"})
        return done.returncode == 0, done.stderr


class Lock(unittest.TestCase):
    def test_the_lock_has_one_hash_for_each_python_and_machine(self):
        text = (ROOT / "host/requirements.txt").read_text()
        self.assertIn(f"CPython {', '.join(PYTHONS)}; each for {', then '.join(MACHINES)}.", text)
        requirement = re.search(r"^lcm==[\d.]+((?: \\\n    --hash=sha256:[0-9a-f]{64})+)\n\Z", text, re.M)
        self.assertIsNotNone(requirement, "one requirement, with its hashes")
        hashes = re.findall("sha256:(.*?)(?: |$)", requirement[1], re.M)
        self.assertEqual(len(set(hashes)), len(PYTHONS) * len(MACHINES))
        self.assertEqual(len(hashes), len(set(hashes)))

    def test_set_up_goes_on_with_those_and_names_them_to_any_other(self):
        for python in PYTHONS:
            for machine in MACHINES:
                self.assertEqual(check_python(f"CPython {python.replace('.', ' ')} {machine}"), (True, ""))
        for other in ("CPython 3 9 x86_64", "CPython 3 15 x86_64", "PyPy 3 11 x86_64", "CPython 3 12 riscv64"):
            with self.subTest(python=other):
                goes_on, said = check_python(other)
                self.assertFalse(goes_on)
                self.assertIn("CPython " + ", ".join(PYTHONS[:-1]) + " and " + PYTHONS[-1], said)
                implementation, major, minor, machine = other.split()
                self.assertIn(f"{implementation} {major}.{minor} on {machine}", said)


if __name__ == "__main__":
    unittest.main()
