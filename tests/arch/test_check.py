"""Each check of the sources finds what is planted, and takes well-made code as it is. Layers and words plant their own."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import check
import test_layers
import test_words
from core import HERE, ROOT

SOUND = """/// Says how many there are.
#include <stddef.h>

size_t how_many(const int* list, size_t length);

size_t how_many(const int* list, size_t length) {
    size_t found = 0;
    for (size_t k = 0; k < length; k++) {
        if (list[k] != 0) found++;
    }
    return found;
}
"""
PLANTED = {
    "format": ("    size_t found = 0;", "  size_t   found=0;", "clang-format"),
    "tidy": ("    size_t found = 0;", "    size_t found;", "core.uninitialized"),
    "cppcheck": ("    return found;", "    const int table[2] = {1, 2};\n    return found + (size_t)table[2];", "arrayIndexOutOfBounds"),
}


def run_check(name, text):
    """Exit code and output of check.py over one file with this text."""
    # Within the tests, where .clang-tidy and the header filter hold; a name of its own keeps it apart from the real sources.
    with tempfile.TemporaryDirectory(prefix="planted.", dir=os.environ["SSV_BUILD_DIR"]) as scratch:
        file = pathlib.Path(scratch) / "planted.c"
        file.write_text(text)
        (file.parent / ".clang-tidy").write_text((ROOT / ".clang-tidy").read_text())
        done = subprocess.run([sys.executable, "-B", HERE / "check.py", name, file], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


class Check(unittest.TestCase):
    def test_each_tool_passes_sound_code_and_finds_what_is_planted_in_it(self):
        for name, (sound, broken, what) in PLANTED.items():
            with self.subTest(name):
                self.assertEqual(run_check(name, SOUND), (0, ""))
                self.assertIn(sound, SOUND)
                code, output = run_check(name, SOUND.replace(sound, broken))
                self.assertEqual(code, 1, output)
                self.assertIn(what, output)
                self.assertRegex(output, r"planted\.c:\d+")

    def test_layers_and_words_find_what_is_planted(self):
        with tempfile.TemporaryDirectory() as scratch:
            root = pathlib.Path(scratch)
            (root / "sim/physics").mkdir(parents=True)
            file = root / "sim/physics/planted.c"
            file.write_text(SOUND)
            self.assertEqual((test_layers.breaches(root), test_words.breaches(root)), ([], []))
            file.write_text(SOUND.replace("<stddef.h>", "<lcm/lcm.h>"))
            self.assertEqual(test_layers.breaches(root), ["sim/physics/planted.c: must not include lcm"])
            file.write_text(SOUND.replace("Says", next(iter(test_words.MARKS))))
            self.assertEqual(len(test_words.breaches(root)), 1)

    def test_every_source_is_checked_but_what_is_for_a_bare_core_or_vendored(self):
        paths = check.sources(".c")
        self.assertLessEqual(check.BARE_METAL, set(paths))
        self.assertIn("tests/fuzz/fuzz_scenario.c", paths)
        self.assertEqual([path for path in paths if "unity" in path], [])

    def test_a_missing_tool_or_build_is_told_with_what_to_do(self):
        done = subprocess.run([sys.executable, "-B", HERE / "check.py", "tidy"], capture_output=True, text=True,
                              env={**os.environ, "PATH": "/nowhere"})
        self.assertEqual(done.returncode, 2)
        self.assertIn("apt-get install clang-tidy", done.stderr)
        done = subprocess.run([sys.executable, "-B", HERE / "check.py", "tidy"], capture_output=True, text=True,
                              env={**os.environ, "SSV_BUILD_DIR": "/nowhere"})
        self.assertEqual(done.returncode, 2)
        self.assertIn("Run tests/run.sh once", done.stderr)

    def test_an_unknown_check_is_wrong_usage(self):
        done = subprocess.run([sys.executable, "-B", HERE / "check.py", "spelling"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 64)


if __name__ == "__main__":
    unittest.main()
