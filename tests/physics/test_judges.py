"""The simulator's physics against two judges from outside: MuJoCo for rigid bodies, SciPy's DOP853 for all of it.

Twenty random flights of vehicle and beam as one piece, for each judge. The water's forces are written apart here, the drag of the
beam's strips by quadrature on panels that shrink towards the slowest strip. MuJoCo builds the pair from two bodies, integrates it
by its own Runge-Kutta method and knows only wrenches; it starts each segment from the state that the physics had there, since a
long flight multiplies the smallest difference. DOP853 integrates momenta about a point that drifts with the water, in axes of the
tank, with added mass, current, weight and buoyancy: no equation of it is one of the C code.

Both must agree within 1e-9 in position [m], attitude [rad], velocity [m/s] and rate [rad/s]. SSV_SEED=N draws other flights.
"""
import os
import random
import subprocess
import sys
import unittest

LONG = bool(os.environ.get("SSV_LONG"))
try:
    import mujoco
    import numpy
    from scipy.integrate import DOP853
except ImportError as missing:
    print(f"No judgement: {missing}. tests/run.sh fetches the judges into build/judges.")
    sys.exit(1 if LONG else 77)  # ctest shows 77 as skipped; the long run takes no such excuse

SEED = int(os.environ.get("SSV_SEED", "20261128"))
FLIGHTS, SEGMENTS = 20, 5
SEGMENT_S = (0.5, 10) if LONG else (0.2, 1.2)
TOLERANCE = 1e-9
STEP_S = 0.001  # of the physics
MUJOCO_STEP_S = 0.0025  # with twice that, MuJoCo's own error comes to 8e-10 rad
PROGRAM = os.environ["SSV_FLY_SEGMENTS"]

HULL_M = 0.3025
THRUSTERS = [(HULL_M * sign * numpy.eye(3)[axis], sign * numpy.eye(3)[push])
             for axis, push in ((2, 0), (0, 1), (1, 2)) for sign in (1, -1)]


def cross(a, b):  # ten times as fast as numpy's, for single vectors
    return numpy.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


WRENCHES = numpy.array([[*direction, *cross(place, direction)] for place, direction in THRUSTERS]).T


class Body:
    """One body, in its principal axes; what is not named is zero."""

    def __init__(self, mass, inertia, **rest):
        self.mass, self.inertia = mass, numpy.array(inertia)
        self.added_mass = numpy.array(rest.get("added_mass", (0, 0, 0)))
        self.added_inertia = numpy.array(rest.get("added_inertia", (0, 0, 0)))
        self.drag = rest.get("drag", (0, 0, 0, 0))  # translation linear, quadratic, rotation linear, quadratic
        self.strip, self.length = rest.get("strip", 0), rest.get("length", 0)
        self.net_weight, self.buoyancy_at = rest.get("net_weight", 0), numpy.array(rest.get("buoyancy_at", (0, 0, 0)))

    def numbers(self):
        return [self.mass, *self.inertia, *self.added_mass, *self.added_inertia, *self.drag, self.strip, self.length,
                self.net_weight, *self.buoyancy_at]


def random_quaternion(draw):
    q = numpy.array([draw.gauss(0, 1) for _ in range(4)])
    return q / numpy.linalg.norm(q)


def matrix(q):
    """Rotation matrix of a quaternion that need not be of unit length."""
    w, u = q[0], numpy.asarray(q[1:])
    skew = numpy.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    return numpy.eye(3) + 2 * (w * skew + skew @ skew) / (w * w + u @ u)


# Gauss-Legendre nodes on panels of [0, 1] that halve towards 0, where the speed of a strip may have a kink.
NODES, WEIGHTS = numpy.polynomial.legendre.leggauss(10)
EDGES = [0.0] + [2.0 ** -k for k in range(14, -1, -1)]
GRADED = numpy.concatenate([a + (b - a) * (NODES + 1) / 2 for a, b in zip(EDGES, EDGES[1:])])
GRADED_WEIGHTS = numpy.concatenate([(b - a) / 2 * WEIGHTS for a, b in zip(EDGES, EDGES[1:])])


def strip_drag(body, v, w):
    """Force and moment of the cross-flow on a tube along z, in its own axes."""
    half = body.length / 2
    turning = w[0] ** 2 + w[1] ** 2
    slowest = -(v[0] * w[1] - v[1] * w[0]) / turning if turning > 0 else 0
    seam = min(max(slowest, -half), half)
    z = numpy.concatenate([seam + (half - seam) * GRADED, seam - (half + seam) * GRADED])
    dz = numpy.concatenate([(half - seam) * GRADED_WEIGHTS, (half + seam) * GRADED_WEIGHTS])
    vx, vy = v[0] + w[1] * z, v[1] - w[0] * z
    push = -body.strip * numpy.hypot(vx, vy) * dz
    fx, fy = push * vx, push * vy
    return numpy.array([fx.sum(), fy.sum(), 0]), numpy.array([-(z * fy).sum(), (z * fx).sum(), 0])


def drag(body, v, w):
    """Force and moment of the water on one body that moves with v and w through it, in its own axes."""
    linear, quadratic, turning_linear, turning_quadratic = body.drag
    force = -(linear + quadratic * numpy.linalg.norm(v)) * v
    moment = -(turning_linear + turning_quadratic * numpy.linalg.norm(w)) * w
    if body.strip:
        strip_force, strip_moment = strip_drag(body, v, w)
        force, moment = force + strip_force, moment + strip_moment
    return force, moment


class Flight:
    """Vehicle and beam joined at random, thrown at random, under thrusts that run on straight lines."""

    def __init__(self, draw, vehicle, beam, current):
        self.bodies, self.current = (vehicle, beam), numpy.array(current)
        angle, height = draw.uniform(-3, 3), draw.uniform(-1.5, 1.5)
        turned = random_quaternion(draw)
        self.q_bB, self.R_bB = turned, matrix(turned)
        # The beam's axis passes the vehicle at the standoff.
        self.p_bB = -self.R_bB @ numpy.array([0.3631 * numpy.cos(angle), 0.3631 * numpy.sin(angle), height])
        self.state = numpy.concatenate([[draw.uniform(-5, 5) for _ in range(3)], random_quaternion(draw),
                                        [draw.uniform(-0.03, 0.03) for _ in range(3)],
                                        [draw.uniform(-0.2, 0.2) for _ in range(3)]])
        thrusts = [[draw.uniform(-6, 6) for _ in range(6)] for _ in range(2 * SEGMENTS)]
        self.segments = [(draw.uniform(*SEGMENT_S), numpy.array(thrusts[2 * k]), numpy.array(thrusts[2 * k + 1]))
                         for k in range(SEGMENTS)]
        self.frames = ((numpy.zeros(3), numpy.eye(3)), (self.p_bB, self.R_bB))

    def flown(self):
        """States of the physics at the end of every segment."""
        numbers = [*self.bodies[0].numbers(), *self.bodies[1].numbers(), 1, *self.p_bB, *self.q_bB]
        for place, direction in THRUSTERS:
            numbers += [*place, *direction]
        numbers += [*self.state, *self.current, STEP_S, len(self.segments)]
        for duration, start, end in self.segments:
            numbers += [duration, *start, *end]
        run = subprocess.run([PROGRAM], input=" ".join(repr(float(x)) for x in numbers), capture_output=True, text=True,
                             check=True)
        return [numpy.array([float(x) for x in line.split()]) for line in run.stdout.splitlines()]

    def thrust(self, segment, t):
        """Force and moment of the thrusters about the vehicle's centre, in its axes."""
        duration, start, end = segment
        u = start + t / duration * (end - start)
        wrench = WRENCHES @ u
        return wrench[:3], wrench[3:]

    def water(self, v, w):
        """The drag's force and moment about the vehicle's centre, in its axes, at v and w through the water."""
        force, moment = numpy.zeros(3), numpy.zeros(3)
        for body, (p, R) in zip(self.bodies, self.frames):
            body_force, body_moment = drag(body, R.T @ (v + cross(w, p)), R.T @ w)
            body_force = R @ body_force
            force += body_force
            moment += R @ body_moment + cross(p, body_force)
        return force, moment


def differences(a, b):
    """Of two states: position [m], attitude [rad], velocity [m/s], rate [rad/s]."""
    apart = min(numpy.linalg.norm(a[3:7] - b[3:7]), numpy.linalg.norm(a[3:7] + b[3:7]))
    return numpy.array([numpy.linalg.norm(a[:3] - b[:3]), 2 * apart, numpy.linalg.norm(a[7:10] - b[7:10]),
                        numpy.linalg.norm(a[10:] - b[10:])])


def spaced(numbers):
    return " ".join(repr(float(x)) for x in numbers)


class MuJoCo:
    """The pair as two bodies of MuJoCo, welded together; positions and moments about the vehicle's centre."""

    def __init__(self, flight):
        vehicle, beam = flight.bodies
        self.flight = flight
        self.model = mujoco.MjModel.from_xml_string(f"""
            <mujoco>
              <compiler balanceinertia="false" boundmass="0" boundinertia="0"/>
              <option integrator="RK4" gravity="0 0 0" density="0" viscosity="0"/>
              <worldbody>
                <body>
                  <freejoint/>
                  <inertial pos="0 0 0" mass="{vehicle.mass!r}" diaginertia="{spaced(vehicle.inertia)}"/>
                  <body pos="{spaced(flight.p_bB)}" quat="{spaced(flight.q_bB)}">
                    <inertial pos="0 0 0" mass="{beam.mass!r}" diaginertia="{spaced(beam.inertia)}"/>
                  </body>
                </body>
              </worldbody>
            </mujoco>""")
        self.data = mujoco.MjData(self.model)

    def fly(self, state, segment):
        """From a state through one segment. Twist and wrench of a free joint: linear in the world, angular in the body."""
        model, data, flight = self.model, self.data, self.flight
        steps = int(numpy.ceil(segment[0] / MUJOCO_STEP_S))
        model.opt.timestep = segment[0] / steps
        data.time = 0
        data.qpos[:] = state[:7]
        data.qvel[:3] = matrix(state[3:7]) @ state[7:10]
        data.qvel[3:] = state[10:]

        def push(_, data):
            R, w = matrix(data.qpos[3:7]), data.qvel[3:]
            thrust, thrust_moment = flight.thrust(segment, data.time)
            water, water_moment = flight.water(R.T @ data.qvel[:3], w)
            data.qfrc_applied[:3] = R @ (thrust + water)
            data.qfrc_applied[3:] = thrust_moment + water_moment

        mujoco.set_mjcb_control(push)
        try:
            for _ in range(steps):
                mujoco.mj_step(model, data)
        finally:
            mujoco.set_mjcb_control(None)
        return numpy.concatenate([data.qpos, matrix(data.qpos[3:7]).T @ data.qvel[:3], data.qvel[3:]])


class Drifting:
    """The same flight as rates of position, attitude and the two momenta, in a frame that drifts with the water.

    The momenta are in axes of the tank, the angular one about the drifting origin: only forces from outside change them."""

    GRAVITY = 9.80665

    def __init__(self, flight):
        self.flight = flight
        self.mass = numpy.zeros((6, 6))  # twist of the vehicle in its axes to [momentum; moment of momentum about its centre]
        for body, (p, R) in zip(flight.bodies, flight.frames):
            skew = numpy.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])
            to_part = numpy.block([[R.T, -R.T @ skew], [numpy.zeros((3, 3)), R.T]])
            own = numpy.diag([*(body.mass + body.added_mass), *(body.inertia + body.added_inertia)])
            self.mass += to_part.T @ own @ to_part

    def to_momenta(self, state):
        R = matrix(state[3:7])
        momentum = self.mass @ numpy.concatenate([state[7:10] - R.T @ self.flight.current, state[10:]])
        linear = R @ momentum[:3]
        return numpy.concatenate([state[:7], linear, R @ momentum[3:] + cross(state[:3], linear)])

    def twist(self, y, R):
        about_centre = R.T @ (y[10:] - cross(y[:3], y[7:10]))
        return numpy.linalg.solve(self.mass, numpy.concatenate([R.T @ y[7:10], about_centre]))

    def to_state(self, y):
        R = matrix(y[3:7])
        twist = self.twist(y, R)
        twist[:3] += R.T @ self.flight.current
        return numpy.concatenate([y[:3], y[3:7] / numpy.linalg.norm(y[3:7]), twist])

    def rates(self, segment, t, y):
        R = matrix(y[3:7])
        twist = self.twist(y, R)
        w = twist[3:]
        thrust, thrust_moment = self.flight.thrust(segment, t)
        water, water_moment = self.flight.water(twist[:3], w)
        force, moment = R @ (thrust + water), R @ (thrust_moment + water_moment)  # about the vehicle's centre
        for body, (p, R_b) in zip(self.flight.bodies, self.flight.frames):
            weight = body.mass * self.GRAVITY
            for size, place in ((-weight, p), (weight - body.net_weight, p + R_b @ body.buoyancy_at)):
                force = force + [0, 0, size]
                moment = moment + cross(R @ place, [0, 0, size])
        q = y[3:7]
        turning = 0.5 * numpy.array([-q[1:] @ w, *(q[0] * w + cross(q[1:], w))])
        return numpy.concatenate([R @ twist[:3], turning, force, moment + cross(y[:3], force)])

    def fly(self, state, segment):
        y = self.to_momenta(state)
        solver = DOP853(lambda t, y: self.rates(segment, t, y), 0, y, segment[0], rtol=1e-12, atol=1e-12)
        while solver.status == "running":
            solver.step()
        drifted = self.to_state(solver.y)
        drifted[:3] += self.flight.current * segment[0]
        return drifted


def vehicle(**rest):
    return Body(76.2, (2.7, 2.7, 2.7), drag=(413.685, 0, 0, 2.2), **rest)


def beam(**rest):
    return Body(11.3636, (8.81, 8.81, 0.0376), strip=66.66, length=3.048, **rest)


def rough_vehicle():
    """Every force that a vehicle may feel."""
    return Body(76.2, (2.7, 2.9, 3.3), added_mass=(30, 41, 52), added_inertia=(0.7, 1.1, 1.6), drag=(80, 120, 1.5, 2.2),
                net_weight=1.3, buoyancy_at=(0.002, -0.001, 0.015))


def rough_beam():
    return Body(11.3636, (8.81, 8.81, 0.0376), added_mass=(35, 35, 0.5), added_inertia=(27, 27, 0.01), drag=(3, 5, 0.2, 0.1),
                strip=66.66, length=3.048, net_weight=-0.7, buoyancy_at=(0, 0.001, 0.01))


class Judges(unittest.TestCase):
    def judge(self, name, worst):
        print(f"\n{name}: {FLIGHTS} flights, seed {SEED}: largest difference {worst[0]:.1e} m, {worst[1]:.1e} rad, "
              f"{worst[2]:.1e} m/s, {worst[3]:.1e} rad/s", flush=True)
        self.assertLess(worst.max(), TOLERANCE)

    def test_each_segment_ends_where_mujoco_ends_it(self):
        worst = numpy.zeros(4)
        for number in range(FLIGHTS):
            flight = Flight(random.Random(1000 * SEED + number), vehicle(), beam(), (0, 0, 0))
            judge, state = MuJoCo(flight), flight.state
            for segment, end in zip(flight.segments, flight.flown(), strict=True):
                worst = numpy.maximum(worst, differences(judge.fly(state, segment), end))
                state = end
        self.judge("MuJoCo " + mujoco.__version__, worst)

    def test_whole_flights_end_where_dop853_ends_them(self):
        """From start to end without resets, in still water and in a current, with every force that there is."""
        worst = numpy.zeros(4)
        for number in range(FLIGHTS):
            draw = random.Random(1000 * SEED + 500 + number)
            rough = number % 2 == 1
            current = [draw.uniform(-0.02, 0.02) for _ in range(3)] if rough else (0, 0, 0)
            flight = Flight(draw, rough_vehicle() if rough else vehicle(), rough_beam() if rough else beam(), current)
            judge, state = Drifting(flight), flight.state
            for segment, end in zip(flight.segments, flight.flown(), strict=True):
                state = judge.fly(state, segment)
                worst = numpy.maximum(worst, differences(state, end))
        self.judge("DOP853", worst)


if __name__ == "__main__":
    unittest.main()
