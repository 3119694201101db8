"""Where the vehicle is, how fast, and with which thrusts, at any time of a plan_t: an example for readers of the messages."""
import math

# Gauss-Legendre, 5 points on [-1, 1].
NODES = [(0.0, 128 / 225)]
for sign in (-1, 1):
    for root, weight in ((math.sqrt(5 - 2 * math.sqrt(10 / 7)) / 3, (322 + 13 * math.sqrt(70)) / 900),
                         (math.sqrt(5 + 2 * math.sqrt(10 / 7)) / 3, (322 - 13 * math.sqrt(70)) / 900)):
        NODES.append((sign * root, weight))


def speed(arc, t):
    """Speed of an arc at t since its start, in closed form from the end that is farther from a terminal speed."""
    a, b, c = arc.dv_dt
    start = abs(a + (b + c * arc.v_start) * arc.v_start) >= abs(a + (b + c * arc.v_end) * arc.v_end)
    v, t = (arc.v_start, t) if start else (arc.v_end, t - arc.duration_s)
    disc, slope = b * b - 4 * a * c, b + 2 * c * v
    root = math.sqrt(abs(disc))
    x = 0.5 * root * t
    tau = 0.5 * t if abs(x) < 1e-8 else (math.tanh(x) if disc > 0 else math.tan(x)) / root
    return v + 2 * (a + (b + c * v) * v) * tau / (1 - slope * tau)


def distance(arc, t):
    """Distance along the leg at t since the arc's start, by quadrature over pieces in which the speed hardly bends."""
    a, b, c = arc.dv_dt
    bends = math.sqrt(abs(b * b - 4 * a * c)) + max(abs(b + 2 * c * arc.v_start), abs(b + 2 * c * arc.v_end))
    pieces = 4 + int(8 * t * bends)
    h = t / pieces
    return arc.s + sum(0.5 * h * weight * speed(arc, (k + 0.5 * (1 + node)) * h)
                       for k in range(pieces) for node, weight in NODES)


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotate(q, v):
    w, e = q[0], q[1:]
    t = [2 * x for x in cross(e, v)]
    return [v[i] + w * t[i] + cross(e, t)[i] for i in range(3)]


def product(a, b):
    vector = cross(a[1:], b[1:])
    return [a[0] * b[0] - sum(x * y for x, y in zip(a[1:], b[1:]))] + \
           [a[0] * b[i + 1] + a[i + 1] * b[0] + vector[i] for i in range(3)]


def pose_along(leg, s):
    """(p_IS, q_IS) after the distance s along the leg's twist."""
    rate = math.sqrt(sum(x * x for x in leg.w_S))
    angle, p, q = rate * s, [s * x for x in leg.v_S], [1.0, 0.0, 0.0, 0.0]
    if angle > 0:
        axis = [x / rate for x in leg.w_S]
        across = cross(axis, p)
        back = cross(axis, across)
        # Below a thousandth the planner goes by the first term of the series, which is off by less than 1e-10 of p.
        bend, fall = (angle / 2, angle ** 2 / 6) if angle < 1e-3 else (
            2 * math.sin(angle / 2) ** 2 / angle, 1 - math.sin(angle) / angle)
        p = [p[i] + bend * across[i] + fall * back[i] for i in range(3)]
        q = [math.cos(angle / 2)] + [math.sin(angle / 2) * x for x in axis]
    start = leg.X_IS_start
    return [x + y for x, y in zip(start.p_m, rotate(start.q, p))], product(start.q, q)


def sample(plan, t):
    """(p_IS, q_IS, v_S, w_S, u_N) of a plan_t at t [s], 0 <= t < plan.quote.time_s."""
    leg = [leg for leg in plan.legs if leg.t_start_s <= t][-1]
    arcs = plan.arcs[leg.first_arc:leg.first_arc + leg.num_arcs]
    arc = [arc for arc in arcs if arc.t_s <= t - leg.t_start_s][-1]
    in_arc = min(t - leg.t_start_s - arc.t_s, arc.duration_s)
    v, (p, q) = speed(arc, in_arc), pose_along(leg, distance(arc, in_arc))
    line = [segment for segment in plan.segments if segment.t_s <= t][-1]
    part = min((t - line.t_s) / line.duration_s, 1)
    u = [start + part * (end - start) for start, end in zip(line.u_start_N, line.u_end_N)]
    return p, q, [v * x for x in leg.v_S], [v * x for x in leg.w_S], u
