"""ssv schedule for structures of 6 to 96 beams: how soon there is a schedule, how far it is from its bound after a minute, how many
prices and how much memory that takes. The long run takes all sizes and a minute each, every other run two sizes and seconds.
"""
import json
import math
import os
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

BIN, LONG = Path(os.environ["SSV_BIN_DIR"]), os.environ.get("SSV_LONG")
# Slots and beams; 8 of 10 is the largest of which the smaller problem behind the bound is solved in full.
SIZES, LIMIT_S = (((6, 6), (8, 10), (12, 12), (24, 24), (48, 48), (96, 96)), 60) if LONG else (((12, 12), (96, 96)), 10)
EDGE_M, HUB_M = 3.81, 0.381  # from centre to centre of two hubs, and from a centre to its ports
IN_SCENE = 64  # hubs and slots that can be in the way of a flight
MEMORY_MAX_MB = 500


def lattice(num_edges):
    """Nodes of the face-centred cubic lattice and the edges between neighbours: from a tetrahedron on, always the node with the most
    neighbours that stand, the nearest to the first."""
    steps = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if abs(x) + abs(y) + abs(z) == 2]
    nodes, edges = [(0, 0, 0)], []

    def links(node):
        return [other for other in nodes if tuple(a - b for a, b in zip(node, other)) in steps]
    while len(edges) < num_edges:
        around = {tuple(a + b for a, b in zip(node, step)) for node in nodes for step in steps} - set(nodes)
        new = max(around, key=lambda node: (len(links(node)), -sum((a - 0.5)**2 for a in node), node))
        edges += [(other, new) for other in links(new)]
        nodes.append(new)
    return nodes, edges[:num_edges]


def structure(num_slots, num_beams):
    """A truss in the water, and its beams in a rack of rows beside it."""
    nodes, edges = lattice(num_slots)
    lines, names, ports = [], {node: f"h{i}" for i, node in enumerate(nodes)}, {node: [] for node in nodes}
    slots = []
    for i, (one, other) in enumerate(edges):
        join = []
        for node, far in ((one, other), (other, one)):
            ports[node].append([(b - a) / math.sqrt(2) for a, b in zip(node, far)])
            join.append(f"{{hub: {names[node]}, port: {len(ports[node])}}}")
        slots.append(f"  - {{name: s{i}, join: [{', '.join(join)}]}}")
    lines += ["model: ease", "vehicle: {p_IS_m: [-9, -4, 2], q_IS: [1, 0, 0, 0]}", "weights: {time: 1, impulse: 1}",
              "attach_heights_m: [1.2, 0, -1.2]", "margin_m: 0.03", "touching: true",
              f"obstacles: {'true' if len(nodes) + len(edges) <= IN_SCENE else 'false'}", "hubs:"]
    for node in nodes:
        lines += [f"  - name: {names[node]}", f"    p_IH_m: {[c * EDGE_M / math.sqrt(2) for c in node]}", "    q_IH: [1, 0, 0, 0]",
                  "    ports:"]
        lines += [f"      - {{p_HP_m: {[HUB_M * c for c in axis]}, axis_H: {axis}}}" for axis in ports[node]]
    lines.append("beams:")
    for i in range(num_beams):
        row, place = divmod(i, 24)
        lines.append(f"  - {{name: b{i}, p_IB_m: [{-10 - 3.5 * row}, {0.5 * (place - min(num_beams, 24) / 2)}, 1], "
                     "q_IB: [0.707106781187, 0, 0.707106781187, 0]}")
    return "\n".join([*lines, "slots:", *slots]) + "\n", len(nodes)


def schedule(text):
    """The schedule, and the most memory [MB] that it took."""
    with tempfile.TemporaryFile("w+") as file:
        file.write(text)
        file.seek(0)
        process = subprocess.Popen([BIN / "ssv", "schedule", "-", "--format", "json", "--time-limit", str(LIMIT_S)], stdin=file,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        stdout, stderr = process.stdout.read(), process.stderr.read()
        process.stdout.close()
        process.stderr.close()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise AssertionError(f"exit code {process.returncode}: {stderr.decode()}")
    return json.loads(stdout), usage.ru_maxrss / 1024


class Sizes(unittest.TestCase):
    def test_structures_of_up_to_96_beams_get_a_schedule(self):
        print(f"\nslots beams hubs obstacles  first s  {'J':>10}  gap after {LIMIT_S} s  to estimate  greedy  prices    MB", flush=True)
        for num_slots, num_beams in SIZES:
            text, num_hubs = structure(num_slots, num_beams)
            start = time.monotonic()
            answer, memory_MB = schedule(text)
            found, search = answer["schedule"], answer["search"]
            gap = found["cost"] / found["lower_bound"] - 1 if found["lower_bound"] > 0 else None
            print(f"{num_slots:5} {num_beams:5} {num_hubs:4} {'yes' if 'obstacles: true' in text else 'no':>9} {search['first_s']:8.1f} "
                  f"{found['cost']:11.1f} {'no bound' if gap is None else f'{100 * gap:.1f} %':>16} "
                  f"{100 * (found['cost'] / found['estimated_least'] - 1):+11.1f} % "
                  f"{'-' if found['greedy_cost'] is None else '%+.1f %%' % (100 * (found['greedy_cost'] / found['cost'] - 1)):>7} "
                  f"{search['prices']:7} {memory_MB:5.0f}", flush=True)
            self.assertEqual(sorted(int(part["slot"][1:]) for part in found["subtasks"]), list(range(num_slots)))
            self.assertEqual(len({part["beam"] for part in found["subtasks"]}), num_slots)
            self.assertLess(memory_MB, MEMORY_MAX_MB)
            self.assertLess(time.monotonic() - start, LIMIT_S + 15)  # a round of prices, and the plans of the parts
            if LONG and num_slots <= 6:
                self.assertLessEqual(gap, 0.05)


if __name__ == "__main__":
    unittest.main(verbosity=2)
