"""Fuzzes the way from the bytes of a scenario, or of a batch of them, to the answer for 30 s (SSV_LONG: 10 minutes),
starting from the shipped scenarios. The seed is printed; SSV_SEED=N takes it again. A failing input is printed in hex."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
SECONDS = 600 if os.environ.get("SSV_LONG") else 30
SEED = int(os.environ.get("SSV_SEED", "20250801"))


class Fuzz(unittest.TestCase):
    def test_no_bytes_crash_the_planner_or_get_an_unsound_answer(self):
        with tempfile.TemporaryDirectory() as folder:
            corpus, found = Path(folder, "corpus"), Path(folder, "found")
            corpus.mkdir()
            found.mkdir()
            subprocess.run([os.environ["SSV_MAKE_CORPUS"], SOURCE / "host/models", corpus,
                            *sorted((SOURCE / "host/scenarios").glob("*.yaml"))], check=True)
            size = max(file.stat().st_size for file in corpus.iterdir())
            run = subprocess.run([os.environ["SSV_FUZZ_SCENARIO"], corpus, f"-max_total_time={SECONDS}", f"-seed={SEED}",
                                  f"-max_len={size}", "-len_control=0", "-timeout=20", "-print_final_stats=1",
                                  f"-artifact_prefix={found}/"], stderr=subprocess.PIPE, text=True, errors="replace")
            print("\n".join([f"SSV_SEED={SEED}", *(line for line in run.stderr.splitlines() if line.startswith("stat::"))]),
                  flush=True)
            inputs = "\n".join(f"{file.name}: {file.read_bytes().hex()}" for file in found.iterdir())
            self.assertEqual(run.returncode, 0, f"{run.stderr[-6000:]}\n{inputs}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
