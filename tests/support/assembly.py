"""The tasks of a schedule one after the other, planned by `ssv plan`: each starts where the one before leaves the vehicle, among all
that stands by then."""
import json
import re
import subprocess

STEPS_PER_UNIT = 1 << 20  # a schedule takes poses in such steps


def turned(q, v):
    w, *u = q
    t = [2 * (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]) for i in range(3)]
    return [v[i] + w * t[i] + u[(i + 1) % 3] * t[(i + 2) % 3] - u[(i + 2) % 3] * t[(i + 1) % 3] for i in range(3)]


def in_steps(X):
    """A pose as a schedule takes it: rounded, with the first number of the quaternion that is not 0 positive."""
    sign = next(-1 if number < 0 else 1 for number in X["q"] if abs(number) > 1 / STEPS_PER_UNIT)
    return {"p_m": [round(number * STEPS_PER_UNIT) / STEPS_PER_UNIT for number in X["p_m"]],
            "q": [sign * round(number * STEPS_PER_UNIT) / STEPS_PER_UNIT for number in X["q"]]}


def read_structure(text):
    """Hubs, ports, beams and slots of a structure file whose lists have an entry a line, as those of host/structures do."""
    def entries(key):
        return re.findall(r"^ *- (\{.*\})", re.search(rf"(?m)^ *{key}:\n((?: *- .*\n)+)", text)[1], re.M)

    def parsed(entry):
        return json.loads(re.sub(r"([A-Za-z]\w*)", r'"\1"', re.sub(r"\be\b", "e", entry)))

    return {key: [parsed(entry) for entry in entries(key)] for key in ("ports", "hubs", "beams", "slots")}


def scheduled_tasks(ssv, path):
    """What `ssv report` takes, of the schedule of a structure without obstacles of its own; and the schedule."""
    structure = read_structure(path.read_text())
    done = subprocess.run([ssv, "schedule", path, "--format", "json"], capture_output=True, text=True, check=True)
    schedule = json.loads(done.stdout)["schedule"]
    beams = {beam["name"]: beam for beam in structure["beams"]}
    hubs = {hub["name"]: hub for hub in structure["hubs"]}
    hub_radius_m = float(re.search(r"(?m)^hub:\n  radius_m: (\S+)", path.read_text())[1])

    def port_of(slot):
        first, hub = slot["join"][0], hubs[slot["join"][0]["hub"]]
        port = structure["ports"][first["port"] - 1]
        return {"p_IP_m": [a + b for a, b in zip(hub["p_IH_m"], turned(hub["q_IH"], port["p_HP_m"]))],
                "axis_I": turned(hub["q_IH"], port["axis_H"])}

    ports = [port_of(slot) for slot in structure["slots"]]
    keys = re.findall(r"(?m)^(?:model|weights|attach_heights_m|margin_m):.*$", path.read_text())
    vehicle = re.search(r"(?m)^vehicle:\n(?:  .*\n)+", path.read_text())[0]
    base = "\n".join([*keys, vehicle, "beam: {p_IB_m: [0, 0, 0], q_IB: [1, 0, 0, 0], contact: either}",
                      "port: {p_IP_m: [9, 0, 0], axis_I: [1, 0, 0]}"])
    question = json.loads(subprocess.run([ssv, "scenario", "-", "--format", "json"], input=base, capture_output=True, text=True, check=True).stdout)
    body = question["scenario"]["beam"]
    spheres = [{"kind": "capsule", "p_I_m": hub["p_IH_m"], "axis_I": [0, 0, 0], "length_m": 0, "radius_m": hub_radius_m} for hub in hubs.values()]
    docked = [{"kind": "capsule", "p_I_m": port["p_IP_m"], "axis_I": port["axis_I"], "length_m": body["length_m"], "radius_m": body["radius_m"]}
              for port in ports]
    scene = question["scene"] | {"num_obstacles": len(spheres) + len(docked), "obstacles": spheres + docked}
    tasks, standing, left, X_IS = [], (1 << len(spheres)) - 1, 0, question["scenario"]["X_IS"]
    for part in schedule["subtasks"]:
        slot = next(i for i, slot in enumerate(structure["slots"]) if slot["name"] == part["slot"])
        beam = beams[part["beam"]]
        scenario = question["scenario"] | {"X_IS": in_steps(X_IS), "X_IB": {"p_m": beam["p_IB_m"], "q": beam["q_IB"]},
                                           "port": ports[slot], "obstacles": f"{standing:016x}", "left": f"{left:016x}"}
        done = subprocess.run([ssv, "plan", "-", "--format", "json"], input=json.dumps({"scenario": scenario, "scene": scene}),
                              capture_output=True, text=True, check=True)
        answer = json.loads(done.stdout)
        tasks.append({"name": f"{part['beam']} to {part['slot']}"} | answer)
        X_IS, left = answer["plan"]["quote"]["X_IS_final"], 1 << len(spheres) + slot
        standing |= left
    return {"tasks": tasks}, schedule
