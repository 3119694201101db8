"""Runs the fuzzer SSV_FUZZ_PROGRAM on its corpus SSV_FUZZ_CORPUS and on inputs drawn from it: for SSV_FUZZ_SECONDS where
that is set, else SSV_FUZZ_RUNS inputs for each of the corpus in all, some 10 s (a count, so that a busy machine tries no
less and a seed tries the same again); with SSV_LONG for 10 minutes. The seed is printed; SSV_SEED=N takes it again. A failing input is printed in hex, with the
command that runs it again."""

import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = Path(os.environ["SSV_FUZZ_PROGRAM"])
CORPUS = Path(os.environ["SSV_FUZZ_CORPUS"])
SECONDS = 600 if os.environ.get("SSV_LONG") else int(os.environ.get("SSV_FUZZ_SECONDS", "0"))
SEED = int(os.environ.get("SSV_SEED", "20250801"))


class Fuzz(unittest.TestCase):
    def test_no_bytes_crash_the_program_or_get_an_unsound_answer(self):
        with tempfile.TemporaryDirectory() as folder:
            new, found = Path(folder, "new"), Path(folder, "found")
            new.mkdir()
            found.mkdir()
            size = max(file.stat().st_size for file in CORPUS.iterdir())
            span = (f"-max_total_time={SECONDS}" if SECONDS
                    else f"-runs={int(os.environ['SSV_FUZZ_RUNS']) * len(list(CORPUS.iterdir()))}")
            run = subprocess.run([PROGRAM, new, CORPUS, span, f"-seed={SEED}", f"-max_len={size}",
                                  "-len_control=0", "-timeout=100", "-print_final_stats=1", f"-artifact_prefix={found}/"],
                                 stderr=subprocess.PIPE, text=True, errors="replace")
            stats = [line for line in run.stderr.splitlines() if line.startswith("stat::")]
            print("\n".join([f"SSV_SEED={SEED}", *stats]), flush=True)
            again = "".join(
                f"\n{file.name}; again:\n  python3 -c 'open(\"found\", \"wb\").write(bytes.fromhex(\"{file.read_bytes().hex()}\"))'"
                f" && {PROGRAM} found\n" for file in found.iterdir())
            self.assertEqual(run.returncode, 0, f"{run.stderr[-6000:]}{again}")
            legal = re.search(r"legal_inputs: (\d+) of (\d+)", run.stderr)
            if legal:  # told by a fuzzer whose inputs are questions: most of them must get past the checks
                self.assertGreater(int(legal[1]), int(legal[2]) / 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
