// The page's own script: draws the data of picture.c as a scene with plots and tables in step. Poses between two rows are
// taken from the straight line between them, which the rows are close enough for; nothing else is computed here.
'use strict';

(function () {

const COLOUR = {
  transit: '#0072b2', transfer: '#e69f00', flown: '#009e73', estimate: '#cc79a7', below: '#d00000',
  hull: '#8fa3b5', beam: '#5a5a5a', obstacle: '#a9a9a9', ink: '#1a1a1a', tank: '#9db4c4'
};
const FADED = 0.2;            // how much is seen of the ways of other tasks
const SPEEDS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200];
const BEAM_OBSTACLE = 64, TANK_OBSTACLE = 65;
const HUB_OFF_M = 0.02;       // how far a beam's line passes by the middle of its hub, or an obstacle lies from the beam that it is
const CLEARANCE_SHOWN_M = 1;  // what is farther away is of no interest
const POINTS_SHOWN = 1500;    // of what was flown, in a plot
const CLOCK_S = 1e-5;         // times have seven digits
const DEG = 180 / Math.PI;
// Columns of a row of a plan, and of one of a flight.
const TIME = 0, POSE = 1, SPEED = 2, RATE = 3, LEG = 4, MATED = 5, NEAR = 6;
const BEAM = 4, FLOWN_NEAR = 5, PLAN_TIME = 6, THRUST = 7;
const LIES = 0, IS_MATED = 1, IS_DOCKED = 2;  // the beam of a row of a flight

const byId = (id) => document.getElementById(id);

// ---- Numbers and elements -------------------------------------------------------------------------------------------

function element(name, attributes, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key in node) node[key] = value; else node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text;
}

function signed(value, digits) {
  const text = fixed(value, digits);
  return text[0] === '-' ? text : '+' + text;
}

const millimetres = (m) => fixed(1e3 * m, 0) + ' mm';

/// The last row whose time is not after t_s; 0 before the first.
function rowAt(rows, t_s) {
  let low = 0, high = rows.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rows[middle][TIME] <= t_s) low = middle; else high = middle;
  }
  return low;
}

function partAt(rows, i, t_s) {
  const next = rows[Math.min(i + 1, rows.length - 1)], span_s = next[TIME] - rows[i][TIME];
  return span_s > 0 ? Math.min(Math.max((t_s - rows[i][TIME]) / span_s, 0), 1) : 0;
}

function positionOf(pose) { return new THREE.Vector3(pose[0], pose[1], pose[2]); }
function attitudeOf(pose) { return new THREE.Quaternion(pose[4], pose[5], pose[6], pose[3]).normalize(); }

function between(a, b, part) {
  return {p: positionOf(a).lerp(positionOf(b), part), q: attitudeOf(a).slerp(attitudeOf(b), part)};
}

function composed(X, Y) {
  return {p: Y.p.clone().applyQuaternion(X.q).add(X.p), q: X.q.clone().multiply(Y.q)};
}

const poseOf = (pose) => ({p: positionOf(pose), q: attitudeOf(pose)});

/// What the plan has at a time of its own clock.
function planAt(task, t_s) {
  const i = rowAt(task.rows, t_s), row = task.rows[i], next = task.rows[Math.min(i + 1, task.rows.length - 1)];
  const part = partAt(task.rows, i, t_s);
  return {
    X_IS: between(row[POSE], next[POSE], part),
    speed_m_s: row[SPEED] + part * (next[SPEED] - row[SPEED]),
    rate_rad_s: row[RATE] + part * (next[RATE] - row[RATE]),
    leg: row[LEG],
    mated: t_s >= task.events_s[0] - CLOCK_S,
    docked: t_s >= task.events_s[1] - CLOCK_S,
    near: part < 0.5 ? row[NEAR] : next[NEAR]
  };
}

function thrustAt(task, t_s) {
  const rows = task.thrust;
  if (t_s < 0 || t_s >= rows[rows.length - 1][TIME] - CLOCK_S) return [0, 0, 0, 0, 0, 0];
  const i = rowAt(rows, t_s), next = rows[Math.min(i + 1, rows.length - 1)], part = partAt(rows, i, t_s);
  return [1, 2, 3, 4, 5, 6].map((k) => rows[i][k] + part * (next[k] - rows[i][k]));
}

// ---- A flight -------------------------------------------------------------------------------------------------------

/// The rows of where the vehicle really was, or is said to have been where nobody knows; none of a plan.
function flownRows(task) {
  if (!task.flight || task.flight.estimate === null || task.flight.estimate.rows.length === 0) return null;
  return trackOf(task).rows;
}

function trackOf(task) {
  const truth = task.flight.truth;
  return truth !== null && truth.rows.length > 0 ? truth : task.flight.estimate;
}

const isUnderWay = (task) => task.flight && task.flight.outcome === 'under_way';

/// The plan's clock at a time of the task's.
function planTime(task, own_s) {
  if (flownRows(task) === null) return own_s;
  const rows = task.flight.estimate.rows, i = rowAt(rows, own_s), next = rows[Math.min(i + 1, rows.length - 1)];
  return rows[i][PLAN_TIME] + partAt(rows, i, own_s) * (next[PLAN_TIME] - rows[i][PLAN_TIME]);
}

/// The time of the task at which the plan's clock shows this: first, where it waits there, and last.
function clockTime(task, plan_s) { return clockSearch(task, plan_s, (shown_s) => shown_s >= plan_s); }
function lastClockTime(task, plan_s) { return clockSearch(task, plan_s, (shown_s) => shown_s > plan_s); }

function clockSearch(task, plan_s, isBehind) {
  if (flownRows(task) === null) return plan_s;
  const rows = task.flight.estimate.rows;
  let low = 0, high = rows.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (isBehind(rows[middle][PLAN_TIME])) high = middle; else low = middle + 1;
  }
  if (low === 0) return Math.min(plan_s, rows[0][TIME]);
  if (low === rows.length && isUnderWay(task)) return rows[low - 1][TIME] + plan_s - rows[low - 1][PLAN_TIME];
  const a = rows[low - 1], b = rows[Math.min(low, rows.length - 1)], span_s = b[PLAN_TIME] - a[PLAN_TIME];
  return span_s > 0 ? a[TIME] + (plan_s - a[PLAN_TIME]) / span_s * (b[TIME] - a[TIME]) : b[TIME];
}

/// Where a leg begins: a wait belongs to the leg before.
const legTime = (task, leg) => leg === 0 ? 0 : lastClockTime(task, task.legs[leg].t_start_s);

function poseAt(rows, t_s) {
  const i = rowAt(rows, t_s);
  return between(rows[i][POSE], rows[Math.min(i + 1, rows.length - 1)][POSE], partAt(rows, i, t_s));
}

/// What was flown at a time of the task, over what was planned.
function flownAt(task, own_s, plan) {
  const track = trackOf(task), rows = track.rows, estimate = task.flight.estimate.rows;
  const i = rowAt(rows, own_s), row = rows[i], next = rows[Math.min(i + 1, rows.length - 1)], part = partAt(rows, i, own_s);
  const k = rowAt(estimate, own_s), beam = Math.max(row[BEAM], estimate[k][BEAM]);
  const X_IS = poseAt(rows, own_s);
  const held = track.X_SB || task.X_SB;
  const X_IB = beam === LIES ? poseOf(task.X_IB_start) : beam === IS_DOCKED && track.X_IB_docked ? poseOf(track.X_IB_docked) : composed(X_IS, poseOf(held));
  return Object.assign(plan, {
    predicted: plan.X_IS, X_IS, X_IB, estimate: track !== task.flight.estimate ? poseAt(estimate, own_s) : null,
    speed_m_s: row[SPEED] + part * (next[SPEED] - row[SPEED]), rate_rad_s: row[RATE] + part * (next[RATE] - row[RATE]),
    mated: beam !== LIES, docked: beam === IS_DOCKED,
    near: part < 0.5 ? row[FLOWN_NEAR] : next[FLOWN_NEAR],
    u_N: estimate[Math.min(k + 1, estimate.length - 1)][THRUST]
  });
}

// ---- What is shown --------------------------------------------------------------------------------------------------

let data = null;          // as picture.c makes it
let shown = [];           // its tasks, with where they begin on the page's clock
let duration_s = 0;
let horizon_s = 0;        // where the plots end: of a flight under way, when it is to end
let now_s = 0;
let plays = false;
let follows = false;
let withLabels = true;
let scene = null;         // what is drawn, null without WebGL
let plots = [];

function taskAt(t_s) {
  let k = shown.length - 1;
  while (k > 0 && shown[k].start_s > t_s) k--;
  return k;
}

/// Where a task left its beam.
const leftBeam = (task) => flownRows(task) !== null ? flownAt(task, task.duration_s, {}).X_IB : poseOf(task.X_IB_final);

/// Where everything is at a time of the page's clock.
function stateAt(t_s) {
  const k = taskAt(t_s), task = shown[k], own_s = t_s - task.start_s;
  const plan_s = planTime(task, own_s), state = Object.assign(planAt(task, plan_s), {task: k, own_s, plan_s, u_N: thrustAt(task, plan_s)});
  state.X_IB = state.docked ? poseOf(task.X_IB_final) : state.mated ? composed(state.X_IS, poseOf(task.X_SB)) : poseOf(task.X_IB_start);
  state.predicted_X_IB = state.X_IB;
  if (flownRows(task) !== null) flownAt(task, own_s, state);
  state.beams = shown.map((other, i) => i === k ? state.X_IB : i < k ? leftBeam(other) : poseOf(other.X_IB_start));
  return state;
}

function obstacleName(task, number) {
  if (number === BEAM_OBSTACLE) return 'its beam';
  if (number === TANK_OBSTACLE) return "the tank's wall";
  const obstacle = task.obstacles.find((one) => one.number === number), carrier = obstacle ? carrierOf(obstacle) : -1;
  if (carrier >= 0) return `the beam of task ${carrier + 1}`;
  return (obstacle && isHub(obstacle) ? 'hub, obstacle ' : 'obstacle ') + number;
}

/// A ball that the line of a docked beam leads to, not far behind one of its ends, is a hub.
function isHub(obstacle) {
  if (obstacle.kind !== 'capsule' || obstacle.length_m > 0) return false;
  return shown.some((task) => {
    const from = new THREE.Vector3().fromArray(obstacle.p_I_m).sub(positionOf(task.X_IB_final));
    const along_m = from.dot(new THREE.Vector3(0, 0, 1).applyQuaternion(attitudeOf(task.X_IB_final)));
    const behind_m = Math.abs(along_m) - task.beam.length_m / 2;
    return behind_m > 0 && behind_m < 4 * Math.max(obstacle.radius_m, task.vehicle.radius_m) &&
      from.lengthSq() - along_m * along_m < HUB_OFF_M * HUB_OFF_M;
  });
}

/// The number of the task that carries this obstacle, a beam that lies or is docked; -1 if none does.
function carrierOf(obstacle) {
  if (shown.length < 2 || obstacle.kind !== 'capsule') return -1;
  const p = new THREE.Vector3().fromArray(obstacle.p_I_m)
    .addScaledVector(new THREE.Vector3().fromArray(obstacle.axis_I), obstacle.length_m / 2);
  return shown.findIndex((task) => Math.abs(obstacle.length_m - task.beam.length_m) < 0.05 &&
    [task.X_IB_start, task.X_IB_final].some((X) => p.distanceTo(positionOf(X)) < HUB_OFF_M));
}

const isBelow = (task, distance_m) => distance_m < Math.max(task.margin_m, 0) - 1e-4;

/// The margin is there for what a flight strays from its plan: one that is flown must touch nothing.
const isTooNear = (task, distance_m) => flownRows(task) !== null ? distance_m < 0 : isBelow(task, distance_m);

// ---- The scene ------------------------------------------------------------------------------------------------------

function material(colour, opacity) {
  return new THREE.MeshLambertMaterial({color: colour, transparent: opacity < 1, opacity, depthWrite: opacity === 1});
}

function mesh(geometry, colour, opacity) { return new THREE.Mesh(geometry, material(colour, opacity === undefined ? 1 : opacity)); }

/// A tube with flat or round ends between two points, as a group that stands along its own z axis from the middle.
function tube(length_m, radius_m, colour, opacity, isRound) {
  const group = new THREE.Group();
  if (length_m > 0) {
    const side = mesh(new THREE.CylinderBufferGeometry(radius_m, radius_m, length_m, 24, 1, isRound), colour, opacity);
    side.rotation.x = Math.PI / 2;
    group.add(side);
  }
  for (const end of isRound ? [-1, 1] : []) {
    const ball = mesh(new THREE.SphereBufferGeometry(radius_m, 24, 16), colour, opacity);
    ball.position.z = end * length_m / 2;
    group.add(ball);
  }
  return group;
}

function place(object, X) {
  object.position.copy(X.p);
  object.quaternion.copy(X.q);
}

const turnFromZ = (axis) => new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis.clone().normalize());

/// A line with a thickness in metres through these points.
function thickLine(points, radius_m, colour) {
  const kept = [];
  for (const p of points) if (kept.length === 0 || p.distanceTo(kept[kept.length - 1]) > 0.05 * radius_m) kept.push(p);
  if (kept.length < 2) return new THREE.Group();
  const curve = new THREE.CatmullRomCurve3(kept, false, 'catmullrom', 0);
  return mesh(new THREE.TubeBufferGeometry(curve, Math.min(4 * kept.length, 3000), radius_m, 6, false), colour);
}

/// An arrow along z with its tail at the origin; scale.z is its length in m.
function arrow(radius_m) {
  const group = new THREE.Group(), dark = new THREE.MeshBasicMaterial({color: COLOUR.ink});
  const shaft = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius_m, radius_m, 0.75, 10), dark);
  const head = new THREE.Mesh(new THREE.ConeBufferGeometry(2.6 * radius_m, 0.25, 14), dark);
  shaft.rotation.x = head.rotation.x = Math.PI / 2;
  shaft.position.z = 0.375;
  head.position.z = 0.875;
  group.add(shaft, head);
  return group;
}

function vehicleBody(vehicle) {
  const group = new THREE.Group(), radius_m = vehicle.radius_m;
  group.add(mesh(new THREE.SphereBufferGeometry(radius_m, 36, 24), COLOUR.hull, 0.45));
  const cone = mesh(new THREE.ConeBufferGeometry(0.3 * radius_m, 0.6 * radius_m, 24), COLOUR.ink);
  cone.rotation.z = -Math.PI / 2;  // its tip is the contact, on +x at the hull
  cone.position.x = 0.7 * radius_m;
  group.add(cone);
  return group;
}

/// The six arrows; the force that a thruster gives starts where it sits.
function thrustArrows(vehicle) {
  return vehicle.thrusters.map((thruster) => {
    const one = arrow(0.035 * vehicle.radius_m);
    one.position.fromArray(thruster.p_ST_m);
    return one;
  });
}

function setThrusts(arrows, vehicle, u_N) {
  vehicle.thrusters.forEach((thruster, i) => {
    const length_m = 2 * vehicle.radius_m * Math.abs(u_N[i]) / vehicle.force_max_N;
    arrows[i].visible = length_m > 1e-3 * vehicle.radius_m;
    if (!arrows[i].visible) return;
    const width = Math.min(1, 4 * length_m / vehicle.radius_m);
    arrows[i].quaternion.copy(turnFromZ(new THREE.Vector3().fromArray(thruster.n_T_S).multiplyScalar(Math.sign(u_N[i]))));
    arrows[i].scale.set(width, width, length_m);
  });
}

function obstacleBody(obstacle, extent_m) {
  const axis = new THREE.Vector3().fromArray(obstacle.axis_I), p = new THREE.Vector3().fromArray(obstacle.p_I_m);
  if (obstacle.kind === 'wall') {
    const group = new THREE.Group();
    const plane = mesh(new THREE.PlaneBufferGeometry(2 * extent_m, 2 * extent_m), COLOUR.obstacle, 0.15);
    plane.material.side = THREE.DoubleSide;
    const grid = new THREE.GridHelper(2 * extent_m, 20, COLOUR.obstacle, COLOUR.obstacle);
    grid.rotation.x = Math.PI / 2;
    group.add(plane, grid);
    group.quaternion.copy(turnFromZ(axis));
    group.position.copy(p);
    return group;
  }
  const body = tube(obstacle.length_m, obstacle.radius_m, COLOUR.obstacle, 1, true);
  if (obstacle.length_m > 0) body.quaternion.copy(turnFromZ(axis));
  body.position.copy(p.addScaledVector(axis, obstacle.length_m > 0 ? obstacle.length_m / 2 : 0));
  return body;
}

function tankBody(tank) {
  const from = tank.from_I_m, to = tank.to_I_m;
  const shape = tank.kind === 'box' ? new THREE.BoxBufferGeometry(to[0] - from[0], to[1] - from[1], to[2] - from[2])
    : new THREE.CylinderBufferGeometry(tank.radius_m, tank.radius_m, to[2] - from[2], 48);
  const lines = new THREE.LineSegments(new THREE.EdgesGeometry(shape, 20), new THREE.LineBasicMaterial({color: COLOUR.tank}));
  if (tank.kind === 'box') {
    lines.position.set((from[0] + to[0]) / 2, (from[1] + to[1]) / 2, (from[2] + to[2]) / 2);
  } else {
    lines.rotation.x = Math.PI / 2;
    lines.position.set(from[0], from[1], (from[2] + to[2]) / 2);
  }
  return lines;
}

/// The port: a ring that the beam's end comes to rest in, and a stub along its axis behind it.
function portBody(port, beam) {
  const group = new THREE.Group(), radius_m = beam.radius_m;
  group.add(mesh(new THREE.TorusBufferGeometry(1.35 * radius_m, 0.3 * radius_m, 10, 28), COLOUR.ink));
  const stub = tube(2 * radius_m, 0.6 * radius_m, COLOUR.ink, 1, false);
  stub.position.z = -radius_m;
  group.add(stub);
  group.quaternion.copy(turnFromZ(new THREE.Vector3().fromArray(port.axis_I)));
  group.position.fromArray(port.p_IP_m);
  return group;
}

/// Every point that a picture must have in it.
function extentOf(tasks) {
  const points = [];
  const around = (p, radius_m) => {
    for (const axis of ['x', 'y', 'z']) for (const sign of [-1, 1]) {
      const q = p.clone();
      q[axis] += sign * radius_m;
      points.push(q);
    }
  };
  for (const task of tasks) {
    const half_m = task.beam.length_m / 2;
    for (const rows of [task.rows, flownRows(task) || []]) {
      rows.forEach((row, i) => { if (i % 4 === 0 || i + 1 === rows.length) around(positionOf(row[POSE]), task.vehicle.radius_m); });
    }
    for (const X of [task.X_IB_start, task.X_IB_final]) for (const end of [-1, 1]) {
      around(new THREE.Vector3(0, 0, end * half_m).applyQuaternion(attitudeOf(X)).add(positionOf(X)), task.beam.radius_m);
    }
    for (const obstacle of task.obstacles) if (obstacle.kind !== 'wall') {
      const p = new THREE.Vector3().fromArray(obstacle.p_I_m);
      around(p, obstacle.radius_m);
      around(p.clone().addScaledVector(new THREE.Vector3().fromArray(obstacle.axis_I), obstacle.length_m), obstacle.radius_m);
    }
  }
  return points;
}

function makeRenderer() {
  try {
    return new THREE.WebGLRenderer({canvas: byId('canvas'), antialias: true, preserveDrawingBuffer: true});
  } catch (error) {
    return null;
  }
}

let renderer;  // one for all that is shown, undefined until the first

function makeScene() {
  if (renderer === undefined) renderer = makeRenderer();
  byId('no_picture').hidden = renderer !== null;
  if (renderer === null) return null;
  const world = new THREE.Scene(), points = extentOf(shown);
  world.background = new THREE.Color('#ffffff');
  const centre = new THREE.Box3().setFromPoints(points).getBoundingSphere(new THREE.Sphere());
  const camera = new THREE.PerspectiveCamera(40, 1, centre.radius / 200, centre.radius * 40);
  camera.up.set(0, 0, 1);
  const sun = new THREE.DirectionalLight('#ffffff', 0.55);
  camera.add(sun);
  sun.position.set(1, 2, 1);
  world.add(camera, new THREE.AmbientLight('#ffffff', 0.65));
  const first = shown[0], made = {world, camera, points, centre, labels: [], flown: []};
  made.thickness_m = Math.max(0.004 * centre.radius, 0.03 * first.vehicle.radius_m);
  const label = (text, p, isSmall) => made.labels.push({text, p, isSmall, node: null});

  made.beams = shown.map((task, k) => {
    const beam = tube(task.beam.length_m, task.beam.radius_m, COLOUR.beam, 1, false);
    world.add(beam);
    if (shown.length > 1) label(String(k + 1), beam.position, false);
    return beam;
  });
  made.ghosts = shown.map((task) => [[task.X_IB_start, 'start'], [task.X_IB_final, 'goal']].map(([X, word]) => {
    const ghost = tube(task.beam.length_m, task.beam.radius_m, word === 'start' ? COLOUR.transit : COLOUR.transfer, 0.25, false);
    place(ghost, poseOf(X));
    world.add(ghost);
    if (shown.length === 1) label(word, positionOf(X), false);
    return ghost;
  }));
  made.ways = shown.map((task, k) => {
    world.add(portBody(task.port, task.beam));
    const ways = [];
    for (const phase of ['transit', 'transfer']) {
      const points = task.rows.filter((row) => task.legs[row[LEG]].phase === phase).map((row) => positionOf(row[POSE]));
      if (phase === 'transit') {
        const end = task.rows.find((row) => row[MATED] === 1);
        if (end) points.push(positionOf(end[POSE]));
      }
      ways.push(thickLine(points, (task.flight ? 0.5 : 1) * made.thickness_m, COLOUR[phase]));
    }
    if (k === 0) label('vehicle, start', positionOf(task.X_IS_start), true);
    world.add(...ways);
    return ways;
  });

  const obstacles = new Map();  // a beam that one task docks is an obstacle of the next, and drawn once
  for (const task of shown) for (const obstacle of task.obstacles) {
    const key = [obstacle.kind, obstacle.p_I_m, obstacle.axis_I, obstacle.length_m].join();
    if (carrierOf(obstacle) < 0) obstacles.set(key, obstacle);
  }
  for (const obstacle of obstacles.values()) {
    world.add(obstacleBody(obstacle, 1.2 * centre.radius));
    if (obstacle.kind !== 'wall') {
      label(isHub(obstacle) ? 'hub' : 'obstacle ' + obstacle.number, new THREE.Vector3().fromArray(obstacle.p_I_m)
        .addScaledVector(new THREE.Vector3().fromArray(obstacle.axis_I), obstacle.length_m / 2), true);
    }
  }
  const tanks = new Map(shown.filter((task) => task.tank).map((task) => [JSON.stringify(task.tank), task.tank]));
  for (const tank of tanks.values()) world.add(tankBody(tank));

  made.vehicle = vehicleBody(first.vehicle);
  made.arrows = thrustArrows(first.vehicle);
  made.vehicle.add(...made.arrows);
  world.add(made.vehicle);
  made.tips = first.vehicle.thrusters.map((thruster, i) => {
    const tip = {text: 'T' + (i + 1), p: new THREE.Vector3(), isSmall: true, node: null};
    made.labels.push(tip);
    return tip;
  });

  made.predicted = tube(0, first.vehicle.radius_m, COLOUR.transit, 0.3, true);
  made.predictedBeam = tube(first.beam.length_m, first.beam.radius_m, COLOUR.transit, 0.3, false);
  made.estimate = mesh(new THREE.SphereBufferGeometry(0.2 * first.vehicle.radius_m, 20, 14), COLOUR.estimate);
  world.add(made.predicted, made.predictedBeam, made.estimate);
  made.near = pairLine();
  made.closest = pairLine();
  world.add(made.near, made.closest);
  made.controls = new THREE.OrbitControls(camera, byId('canvas'));
  made.controls.enableKeys = false;
  made.controls.screenSpacePanning = true;
  made.controls.addEventListener('change', () => { made.isStale = true; });
  byId('labels').replaceChildren();
  for (const one of made.labels) {
    one.node = element('span', {className: one.isSmall ? 'small' : ''}, one.text);
    byId('labels').append(one.node);
  }
  return made;
}

/// The ways that were flown, anew.
function drawFlown() {
  for (const {line} of scene.flown) {
    scene.world.remove(line);
    if (line.geometry) line.geometry.dispose();
  }
  scene.flown = [];
  shown.forEach((task, k) => {
    const rows = flownRows(task), points = (from) => someOf(from).map((row) => positionOf(row[POSE]));
    if (rows === null) return;
    scene.flown.push({task: k, line: thickLine(points(rows), scene.thickness_m, COLOUR.flown)});
    if (rows !== task.flight.estimate.rows) scene.flown.push({task: k, line: thickLine(points(task.flight.estimate.rows), 0.4 * scene.thickness_m, COLOUR.estimate)});
  });
  if (scene.flown.length > 0) scene.world.add(...scene.flown.map(({line}) => line));
}

/// A line between two bodies, as thick as a thumb.
function pairLine() {
  const line = new THREE.Mesh(new THREE.CylinderBufferGeometry(1, 1, 1, 8), new THREE.MeshBasicMaterial({color: COLOUR.below}));
  line.material.depthTest = false;
  line.material.transparent = true;  // so it comes after the hull, which is
  line.renderOrder = 1;
  line.visible = false;
  return line;
}

function setPairLine(line, near, thickness_m, colour) {
  line.visible = near !== null;
  if (near === null) return;
  const a = new THREE.Vector3(near[3], near[4], near[5]), b = new THREE.Vector3(near[6], near[7], near[8]);
  const along = b.clone().sub(a), length_m = Math.max(along.length(), 1e-6);
  line.material.color.set(colour);
  line.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length_m));
  line.position.copy(a).add(b).multiplyScalar(0.5);
  line.scale.set(thickness_m, Math.max(length_m, 2 * thickness_m), thickness_m);  // to be seen from afar, too
}

/// Puts the camera where all of it can be seen from this direction.
function frame(direction) {
  if (scene === null) return;
  const {camera, controls} = scene;
  const back = direction.clone().normalize(), right = new THREE.Vector3().crossVectors(camera.up, back);
  if (right.length() < 1e-3) right.set(1, 0, 0);
  right.normalize();
  const up = new THREE.Vector3().crossVectors(back, right);
  const tall = Math.tan(camera.fov / 2 / DEG), wide = tall * camera.aspect;
  // For each side of the picture, how far back along `back` its plane must be; the middle between opposite ones is the target.
  const reach = (axis, slope) => {
    let most = -Infinity, least = Infinity;
    for (const p of scene.points) {
      const depth = p.dot(back) * slope;
      most = Math.max(most, p.dot(axis) + depth);
      least = Math.min(least, p.dot(axis) - depth);
    }
    return {middle: (most + least) / 2, back: (most - least) / 2 / slope};
  };
  const across = reach(right, 0.94 * wide), upward = reach(up, 0.88 * tall);
  const depth = Math.max(across.back, upward.back);
  camera.position.set(0, 0, 0).addScaledVector(right, across.middle).addScaledVector(up, upward.middle).addScaledVector(back, depth);
  controls.target.copy(camera.position).addScaledVector(back, scene.centre.center.dot(back) - depth);
  if (Math.abs(back.z) > 0.999) camera.position.y -= 1e-3 * depth;  // straight down has no heading
  controls.update();
  scene.isStale = true;
}

const SLANT = new THREE.Vector3(0.55, -1, 0.6);

function resize() {
  if (scene === null) return;
  const box = byId('view');
  const width = box.clientWidth, height = box.clientHeight;
  renderer.setPixelRatio(window.devicePixelRatio || 1);
  renderer.setSize(width, height, false);
  scene.camera.aspect = width / height;
  scene.camera.updateProjectionMatrix();
  scene.isStale = true;
}

function placeLabels() {
  const box = byId('view');
  for (const label of scene.labels) {
    const p = label.p.clone().project(scene.camera);
    label.node.hidden = !withLabels || label.isHidden || Math.abs(p.x) > 1 || Math.abs(p.y) > 1 || p.z > 1;
    label.node.style.left = ((p.x + 1) / 2 * box.clientWidth + 6).toFixed(1) + 'px';
    label.node.style.top = ((1 - p.y) / 2 * box.clientHeight - 8).toFixed(1) + 'px';
  }
}

/// Lets a line of thickLine show through, or not.
function fade(line, opacity) {
  if (!line.material || line.material.opacity === opacity) return;
  line.material.opacity = opacity;
  line.material.transparent = opacity < 1;
  line.material.depthWrite = opacity === 1;
  line.material.needsUpdate = true;
}

function drawScene(state) {
  const task = shown[state.task];
  const before = scene.vehicle.position.clone();
  place(scene.vehicle, state.X_IS);
  state.beams.forEach((X, i) => {
    place(scene.beams[i], X);
    const isTaken = i < state.task || (i === state.task && state.mated), stands = i < state.task || (i === state.task && state.docked);
    [scene.ghosts[i][0].visible, scene.ghosts[i][1].visible] = [isTaken, !stands];
    for (const way of scene.ways[i]) fade(way, i === state.task ? 1 : FADED);
  });
  for (const {task: of, line} of scene.flown) fade(line, of === state.task ? 1 : FADED);
  setThrusts(scene.arrows, task.vehicle, state.u_N);
  scene.tips.forEach((tip, i) => {
    tip.p.fromArray(task.vehicle.thrusters[i].p_ST_m).applyQuaternion(state.X_IS.q).add(state.X_IS.p);
    tip.isHidden = !scene.arrows[i].visible;
  });
  const isFlown = flownRows(task) !== null, phase = task.legs[state.leg].phase;
  scene.predicted.visible = scene.predictedBeam.visible = isFlown;
  scene.estimate.visible = isFlown && state.estimate !== null;
  if (isFlown) {
    place(scene.predicted, {p: state.predicted.p, q: state.predicted.q});
    place(scene.predictedBeam, state.predicted_X_IB);
    for (const ghost of [scene.predicted, scene.predictedBeam]) ghost.traverse((part) => { if (part.material) part.material.color.set(COLOUR[phase]); });
  }
  if (scene.estimate.visible) place(scene.estimate, state.estimate);
  const thin_m = 0.0025 * scene.centre.radius;
  const near = state.near !== null && state.near[0] < CLEARANCE_SHOWN_M ? state.near : null;
  setPairLine(scene.near, near, thin_m, near !== null && isTooNear(task, near[0]) ? COLOUR.below : COLOUR.ink);
  const closest = task.clearance && isBelow(task, task.clearance.certified_m) ? planAt(task, task.clearance.t_s).near : null;
  setPairLine(scene.closest, closest, 4 * thin_m, COLOUR.below);
  if (follows) {
    const moved = state.X_IS.p.clone().sub(before);
    scene.camera.position.add(moved);
    scene.controls.target.add(moved);
    scene.controls.update();
  }
  renderer.render(scene.world, scene.camera);
  placeLabels();
  scene.isStale = false;
}

// ---- Plots ----------------------------------------------------------------------------------------------------------

function shade(canvas, area, graph) {
  for (const task of shown) {
    task.legs.forEach((leg, i) => {
      const from = graph.toDomXCoord(task.start_s + legTime(task, i));
      const to = graph.toDomXCoord(task.start_s + (i + 1 < task.legs.length ? legTime(task, i + 1) : Math.max(task.duration_s, clockTime(task, task.price.time_s))));
      canvas.fillStyle = leg.phase === 'transit' ? '#0072b218' : '#e69f0022';
      canvas.fillRect(from, area.y, to - from, area.h);
      canvas.fillStyle = i === 0 && shown.length > 1 ? '#1a1a1a' : '#bbbbbb';
      canvas.fillRect(from, area.y, 1, area.h);
    });
  }
}

/// One small plot below another; all have the same stretch of time.
function addPlot(name, unit, rowsOf, options) {
  const label = element('b', {}, `${name} [${unit}]`), value = element('span', {});
  const graphBox = element('div', {className: 'graph'}), line = element('div', {className: 'line'});
  const box = element('div', {className: options.isWide ? 'plot wide' : 'plot'}, element('div', {className: 'name'}, label, value), graphBox, line);
  if (options.second) box.querySelector('.name').append(element('b', {className: 'second'}, options.second));
  byId('plots').append(box);
  const labels = ['t', ...options.series.map((series) => series.name)];
  const series = {};
  for (const one of options.series) {
    series[one.name] = {color: one.colour, axis: one.axis || 'y1', strokePattern: one.pattern || null, strokeWidth: one.width || 1.4, stepPlot: one.isStep === true};
  }
  const graph = new Dygraph(graphBox, rowsOf(), {
    labels, series, legend: 'never', highlightCircleSize: 0, connectSeparatedPoints: true,  // null is where another series has a point; NaN is a gap
    axes: {
      x: {axisLabelFormatter: (t) => t + ' s', pixelsPerLabel: 70, axisLabelWidth: 60},
      y: Object.assign({axisLabelWidth: 42, pixelsPerLabel: 18, valueRange: options.range || null, axisLabelFormatter: (v) => String(+v.toPrecision(6))},
        options.ticks ? {ticker: () => options.ticks.map((v) => ({v, label: String(v)}))} : {}),
      y2: {axisLabelWidth: 42, pixelsPerLabel: 18, drawGrid: false, independentTicks: true}
    },
    dateWindow: [0, horizon_s],
    xRangePad: 0,
    rightGap: options.isWide ? rightGap() : 5,
    underlayCallback: (canvas, area, g) => {
      shade(canvas, area, g);
      if (options.limit) {
        canvas.fillStyle = COLOUR.below;
        const y = g.toDomYCoord(options.limit);
        for (let x = area.x; x < area.x + area.w; x += 10) canvas.fillRect(x, y, 6, 1.5);
      }
    },
    drawCallback: (g, isInitial) => { if (!isInitial) zoomAll(g); },
    clickCallback: (event, t_s) => setTime(t_s)
  });
  plots.push({graph, line, value, read: options.read, rowsOf, box});
}

/// What wide plots keep free at their right [pixels], so that one with a second axis has its times above those of the next.
function rightGap() {
  const first = plots.find((plot) => plot.box.classList.contains('wide'));
  if (first === undefined) return 5;
  const area = first.graph.getArea();
  return first.graph.graphDiv.offsetWidth - area.x - area.w;
}

let isZooming = false;

function zoomAll(source) {
  if (isZooming) return;
  isZooming = true;
  const [from, to] = source.xAxisRange();
  for (const plot of plots) {
    const [a, b] = plot.graph.xAxisRange();
    if (plot.graph !== source && (a !== from || b !== to)) plot.graph.updateOptions({dateWindow: [from, to]});
  }
  isZooming = false;
  placeNowLines();
}

function placeNowLines() {
  for (const plot of plots) {
    const area = plot.graph.getArea(), x = plot.graph.toDomXCoord(now_s);
    const offset = plot.graph.graphDiv.parentNode.offsetLeft;
    plot.line.hidden = x < area.x - 1 || x > area.x + area.w + 1;
    plot.line.style.left = (offset + x).toFixed(2) + 'px';
  }
}

/// Rows of all tasks on the page's clock, [time, value...].
const onClock = (rowsOf, timeOf, pick) => [].concat(...shown.map((task) => rowsOf(task).map((row, i) => [task.start_s + timeOf(task, row, i), ...pick(task, row)])));
const byPlan = (task, row) => clockTime(task, row[TIME]);
const byFlight = (task, row) => row[TIME];
/// A thruster's timeline on the page's clock, of starts and ends of segments in turn; no thrust while the plan's clock waits.
function timelineOf(task, k) {
  const points = [];
  task.thrust.forEach((row, i) => {
    const first_s = clockTime(task, row[TIME]), last_s = lastClockTime(task, row[TIME]);
    if (i % 2 === 0 && i > 0 && last_s > first_s) points.push([first_s, 0], [last_s, 0]);
    points.push([i % 2 === 0 && i > 0 ? last_s : first_s, row[1 + k]]);
  });
  return points;
}

/// Puts series with times of their own side by side: [time, a..., b...], null where one has nothing to say.
function merged(a, b, isFlown, behind = 1) {
  if (!isFlown) return a;
  const before = a[0].length - 1, none = (count) => Array(count).fill(null);
  return a.map((row) => [...row, ...none(behind)]).concat(b.map((row) => [row[0], ...none(before), ...row.slice(1)])).sort((x, y) => x[0] - y[0]);
}

/// Means since the row before, as steps: each stands from the row before on.
function thrustSteps(task, k) {
  if (flownRows(task) === null) return [];
  const rows = someOf(task.flight.estimate.rows);
  return rows.map((row, i) => [row[TIME], rows[Math.min(i + 1, rows.length - 1)][THRUST][k]]);
}

const metres = (near) => near === null ? NaN : near[0];

function makePlots() {
  for (const plot of plots) plot.graph.destroy();
  plots = [];
  byId('plots').replaceChildren();
  const most_N = shown[0].vehicle.force_max_N, isFlown = shown.some((task) => task.flight);
  const grey = '#999999', brown = '#8a5f00', thick = isFlown ? 2.5 : 1.4;
  for (let k = 0; k < 6; k++) {
    const predicted = {name: 'predicted', colour: isFlown ? grey : COLOUR.ink, width: thick};
    addPlot('T' + (k + 1), 'N', () => merged(onClock((task) => timelineOf(task, k), byFlight, (task, row) => [row[1]]),
      onClock((task) => thrustSteps(task, k), byFlight, (task, row) => [row[1]]), isFlown), {
      series: isFlown ? [predicted, {name: 'commanded', colour: COLOUR.flown, isStep: true}] : [predicted],
      range: [-1.15 * most_N, 1.15 * most_N], ticks: [-most_N, 0, most_N], read: (state) => signed(state.u_N[k], 2) + ' N'
    });
  }
  const speeds = (task, row) => [row[SPEED], row[RATE] * DEG];
  addPlot('Speed', 'm/s', () => merged(onClock((task) => task.rows, byPlan, speeds), onClock(flownOrNone, byFlight, speeds), isFlown, 2), {
    isWide: true, second: 'Rate [deg/s], dashed, at right',
    series: [{name: 'v', colour: isFlown ? grey : COLOUR.transit, width: thick}, {name: 'w', colour: isFlown ? grey : brown, axis: 'y2', pattern: [5, 3]}]
      .concat(isFlown ? [{name: 'v flown', colour: COLOUR.flown}, {name: 'w flown', colour: brown, axis: 'y2', pattern: [5, 3]}] : []),
    read: (state) => `${fixed(state.speed_m_s, 3)} m/s\n${fixed(state.rate_rad_s * DEG, 2)} deg/s`
  });
  if (shown.some((task) => task.rows.some((row) => row[NEAR] !== null))) addClearancePlot(isFlown);
  if (isFlown) addStrayPlot();
}

/// Some of many rows, as many as a picture can show.
function someOf(rows) {
  const step = Math.ceil(rows.length / POINTS_SHOWN);
  return step <= 1 ? rows : rows.filter((row, i) => i % step === 0 || i + 1 === rows.length);
}

const flownOrNone = (task) => someOf(flownRows(task) || []);

function addClearancePlot(isFlown) {
  const planned = () => onClock((task) => task.rows, byPlan, (task, row) => {
    const m = metres(row[NEAR]);
    return [m, isBelow(task, m) ? m : NaN];
  });
  const really = () => onClock(flownOrNone, byFlight, (task, row) => [metres(row[FLOWN_NEAR])]);
  const least = [...planned(), ...really()].reduce((so_far, row) => row[1] < so_far ? row[1] : so_far, 0);
  addPlot('Clearance', 'm', () => merged(planned(), really(), isFlown), {
    isWide: true, range: [Math.min(1.1 * least, -0.02), CLEARANCE_SHOWN_M], limit: shown[0].margin_m,
    series: [{name: 'clearance', colour: isFlown ? '#999999' : COLOUR.ink, width: isFlown ? 2.5 : 1.4}, {name: 'below', colour: COLOUR.below, width: 3}]
      .concat(isFlown ? [{name: 'flown', colour: COLOUR.flown}] : []),
    read: (state) => state.near === null ? '' : fixed(state.near[0], 3) + ' m'
  });
}

/// How far the vehicle was from where the plan has it at that time of its clock, and from where it thought it was.
function addStrayPlot() {
  const strays = (task, row) => {
    const p = positionOf(row[POSE]), thought = trackOf(task) !== task.flight.estimate ? poseAt(task.flight.estimate.rows, row[TIME]).p : null;
    return [1e3 * p.distanceTo(planAt(task, row[PLAN_TIME]).X_IS.p), thought === null ? NaN : 1e3 * p.distanceTo(thought)];
  };
  addPlot('Off the plan', 'mm', () => {
    const rows = onClock(flownOrNone, byFlight, strays);
    return rows.length > 0 ? rows : [[0, NaN, NaN]];
  }, {
    isWide: true, second: 'Off the estimate [mm], purple',
    series: [{name: 'plan', colour: COLOUR.flown}, {name: 'estimate', colour: COLOUR.estimate}],
    read: (state) => state.predicted ? fixed(1e3 * state.X_IS.p.distanceTo(state.predicted.p), 0) + ' mm' : ''
  });
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

function table(head, rows) {
  const isNumber = (content, i) => i > 0 && /^[-+]?[\d.]+$/.test(content instanceof Node ? content.textContent : content);
  const cell = (content, i) => element('td', {className: isNumber(content, i) ? 'number' : ''}, content instanceof Node ? content : String(content));
  const body = element('tbody', {}, ...rows.map((row) => {
    const tr = element('tr', {className: row.className || ''}, ...row.cells.map(cell));
    if (row.go) {
      tr.className = 'jump';
      tr.tabIndex = 0;
      tr.addEventListener('click', row.go);
      tr.addEventListener('keydown', (event) => { if (event.key === 'Enter') row.go(); });
    }
    return tr;
  }));
  const parts = head ? [element('thead', {}, element('tr', {}, ...head.map((text) => element('th', {className: /\[/.test(text) ? 'number' : ''}, text))))] : [];
  return element('table', {}, ...parts, body);
}

function clearanceText(task) {
  const c = task.clearance;
  if (c === null) return 'there is nothing around';
  const where = `leg ${c.leg + 1}, at ${fixed(c.t_s, 1)} s`, what = obstacleName(task, c.obstacle);
  return c.certified_m < 0 ? `${millimetres(-c.certified_m)} too little: ${c.body} in ${what} (${where})` : `${millimetres(c.certified_m)} at least (${c.body} to ${what}, ${where})`;
}

function priceTable(task) {
  const price = task.price, gap = 100 * (price.cost / price.cost_lower_bound - 1);
  const clear = element('span', {}, clearanceText(task));
  if (task.clearance && isBelow(task, task.clearance.certified_m)) clear.className = 'below';
  return table(null, [
    {cells: ['J', `${fixed(price.cost, 3)} = ${+price.weight_time_per_s.toPrecision(6)} /s × ${fixed(price.time_s, 3)} s + ` +
      `${+price.weight_impulse_per_Ns.toPrecision(6)} /(N s) × ${fixed(price.impulse_Ns, 3)} N s`]},
    {cells: ['none below', `${fixed(price.cost_lower_bound, 3)}` + (price.cost_lower_bound > 0 ? `: this one is at most ${fixed(gap, 1)} % above the best possible` : '')]},
    {cells: ['mates', `at height ${signed(price.attach_height_m, 4)} m, ring angle ${signed(price.ring_angle_rad * DEG, 1)} deg; contact ${price.contact} docks`]},
    {cells: ['chosen from', `${price.candidates} combinations, method ${price.method}` + (price.method === 'optimal' ? `, effort ${price.effort}` : '') +
      (price.thrust_reserve > 0 ? `, ${fixed(100 * price.thrust_reserve, 0)} % of the thrust in reserve` : '')]},
    {cells: ['keeps clear by', clear]},
    {cells: ['margin', task.margin_m > 0 ? millimetres(task.margin_m) : 'none asked for']},
    {cells: ['plan', `${price.plan_hash}, planned in ${price.scalar}`]}
  ]);
}

function legsTable(task) {
  const rows = task.legs.map((leg, i) => ({
    go: () => setTime(task.start_s + legTime(task, i)),
    cells: [element('span', {}, element('i', {className: 'swatch', style: `background: ${COLOUR[leg.phase]}`}), leg.phase), leg.kind, leg.ramp.replace('_', ' '),
      fixed(leg.t_start_s, 3), fixed(leg.duration_s, 3), fixed(leg.impulse_Ns, 3), fixed(leg.peak_speed, 4) + (leg.kind === 'turn' ? ' rad/s' : ' m/s')]
  }));
  return table(['phase', 'leg', 'ramp', 'start [s]', 'time [s]', 'impulse [N s]', 'peak speed'], rows);
}

/// Predicted beside flown, leg by leg.
function flightTable(task) {
  const flight = task.flight, sum = (pick) => flight.legs.reduce((total, leg) => total + (leg === null ? 0 : pick(leg)), 0);
  const row = (leg, i) => {
    const flown = flight.legs[i];
    return {
      go: () => setTime(task.start_s + legTime(task, i)),
      cells: [element('span', {}, element('i', {className: 'swatch', style: `background: ${COLOUR[leg.phase]}`}), leg.phase), leg.kind,
        fixed(leg.duration_s, 1), flown ? fixed(flown.time_s, 1) : '-', flown ? fixed(flown.wait_s, 1) : '-', fixed(leg.impulse_Ns, 1), flown ? fixed(flown.impulse_Ns, 1) : '-']
    };
  };
  const all = {cells: ['in all', '', fixed(task.price.time_s, 1), fixed(flight.flown_s, 1), fixed(sum((leg) => leg.wait_s), 1), fixed(task.price.impulse_Ns, 1), fixed(flight.impulse_Ns, 1)]};
  return table(['phase', 'leg', 'planned [s]', 'flown [s]', 'wait [s]', 'planned [N s]', 'flown [N s]'], [...task.legs.map(row), all]);
}

function flightFacts(task) {
  const flight = task.flight;
  const attempt = (name, one) => one === null ? [] : [{cells: [name, `${one.outcome}: ${fixed(1e3 * one.position_m, 1)} mm and ${fixed(one.angle_rad * DEG, 2)} deg off at ${fixed(1e3 * one.speed_m_s, 1)} mm/s`]}];
  return table(null, [
    {cells: ['flight', flight.outcome.replace('_', ' ') + (flight.outcome !== 'docked' && flight.reason ? ': ' + flight.reason : '') + `, ${flight.attempts} attempts`]},
    ...attempt('mate', flight.mate), ...attempt('dock', flight.dock),
    ...isUnderWay(task) && live.execution ? liveFacts(live.execution) : [],
    ...flight.num_plans > 1 ? [{cells: ['planned anew', `${flight.num_plans - 1} times; what is predicted is the first plan`]}] : [],
    ...flight.seed ? [{cells: ['simulated', `conditions ${flight.conditions || 'none'}, seed ${flight.seed}`]}] : []
  ]);
}

function tasksTable() {
  return table(['task', 'starts [s]', 'time [s]', 'J [-]', 'clear [m]'], shown.map((task, k) => ({
    go: () => setTime(task.start_s),
    cells: [`${k + 1}  ${task.name}`, fixed(task.start_s, 1), fixed(task.price.time_s, 1), fixed(task.price.cost, 1),
      task.clearance ? element('span', {className: isBelow(task, task.clearance.certified_m) ? 'below' : ''}, fixed(task.clearance.certified_m, 3)) : '-']
  })));
}

let tabled = -1;  // the task whose tables are shown

function drawTables(state) {
  const task = shown[state.task];
  if (tabled !== state.task || live.isStale) {
    tabled = state.task;
    const hasLegs = task.flight && task.flight.legs.some((leg) => leg !== null);
    const flight = task.flight ? [element('h2', {}, 'Flight'), flightFacts(task), ...hasLegs ? [flightTable(task)] : []] : [];
    byId('tables').replaceChildren(...flight, element('h2', {}, shown.length > 1 ? `Price of ${task.name}` : 'Price'), priceTable(task),
      ...hasLegs ? [] : [element('h2', {}, 'Legs'), legsTable(task)]);
    byId('tasks').replaceChildren(...shown.length > 1 ? [element('h2', {}, 'Tasks'), tasksTable()] : []);
  }
  const mark = (holder, at) => [...holder.querySelectorAll('tbody tr.jump')].forEach((row, i) => row.classList.toggle('at', i === at));
  mark(byId('tables'), state.leg);
  mark(byId('tasks'), state.task);
}

function drawNow(state) {
  const task = shown[state.task], leg = task.legs[state.leg];
  const what = state.docked ? 'docked' : `${leg.phase}, ${leg.kind}` + (state.mated ? ', with the beam' : '');
  const near = state.near === null ? '' : `\n${state.near[1] === 1 ? 'beam' : 'vehicle'} to ${obstacleName(task, state.near[2])}: ${fixed(state.near[0], 3)} m`;
  byId('now').textContent = (shown.length > 1 ? task.name + ': ' : '') + `leg ${state.leg + 1} of ${task.legs.length}: ${what}${near}`;
  byId('now').className = state.near !== null && isTooNear(task, state.near[0]) ? 'below' : '';
}

function drawHead() {
  const broken = shown.filter((task) => task.breach !== ''), below = shown.filter((task) => task.clearance && isBelow(task, task.clearance.certified_m));
  const sum = (pick) => shown.reduce((total, task) => total + pick(task), 0);
  document.title = data.title;
  byId('title').textContent = data.title;
  const flights = live.isOn ? [] : shown.filter((task) => task.flight), docked = flights.filter((task) => task.flight.outcome === 'docked');
  const outcome = shown.length > 1 ? `${docked.length} of ${shown.length} docked` : flights.map((task) => task.flight.outcome.replace('_', ' ')).join();
  const flown = (pick) => fixed(flights.reduce((total, task) => total + pick(task.flight), 0), 1);
  byId('headline').textContent = (flights.length === 0 ? '' :
    `${outcome} after ${flown((flight) => flight.flown_s)} s and ${flown((flight) => flight.impulse_Ns)} N s; planned: `) + `J = ${fixed(sum((task) => task.price.cost), 3)}, ${fixed(sum((task) => task.price.time_s), 1)} s, ` +
    `${fixed(sum((task) => task.price.impulse_Ns), 1)} N s` + (shown.length > 1 ? `, ${shown.length} tasks` : '');
  const sentences = broken.map((task) => `${task.name}: this plan is no answer to its question: ${task.breach}.`)
    .concat(below.map((task) => (shown.length > 1 ? task.name + ': ' : '') + (task.margin_m > 0 ? `closer than the margin of ${millimetres(task.margin_m)}: `
      : 'no margin was asked for, and two bodies meet: ') + clearanceText(task) + '.'));
  byId('warning').textContent = sentences.join(' ');
  const isFlown = shown.some((task) => task.flight), planned = isFlown ? 'planned, ' : '', last = shown[shown.length - 1];
  const entries = [[planned + 'vehicle alone', COLOUR.transit], [planned + 'with the beam', COLOUR.transfer]];
  if (isFlown) entries.push([last.flight && last.flight.truth ? 'flown, in truth' : 'flown, as estimated', COLOUR.flown]);
  if (isFlown && last.flight && last.flight.truth) entries.push(['as estimated', COLOUR.estimate]);
  if (below.length > 0) entries.push(['closer than the margin', COLOUR.below]);
  byId('warning').hidden = sentences.length === 0;
  byId('legend').replaceChildren(...entries.map(([text, colour]) => element('li', {}, element('i', {style: `border-color: ${colour}`}), text)));
  byId('foot').textContent = 'SI units. Frame I: z up. An arrow is the force of a thruster on the vehicle; as long as the hull is wide, it is the most that a thruster can give.';
}

// ---- Time -----------------------------------------------------------------------------------------------------------

function draw() {
  const state = stateAt(now_s);
  if (scene !== null) drawScene(state);
  placeNowLines();
  for (const plot of plots) plot.value.textContent = plot.read(state);
  byId('slider').value = String(now_s);
  byId('clock').textContent = `${fixed(now_s, 1)} of ${fixed(duration_s, 1)} s`;
  drawTables(state);
  drawNow(state);
}

function setTime(t_s) {
  now_s = Math.min(Math.max(t_s, 0), duration_s);
  draw();
}

function play(yes) {
  if (yes && now_s >= duration_s) now_s = 0;
  plays = yes;
  byId('play').textContent = yes ? 'Stop' : 'Play';
}

let frame_ms = 0;

function turn(ms) {
  const passed_s = Math.min((ms - frame_ms) / 1e3, 0.2);
  frame_ms = ms;
  if (live.isOn) drawLive(ms);
  if (plays) {
    setTime(now_s + passed_s * Number(byId('speed').value));
    if (now_s >= duration_s) play(false);
  } else if (scene !== null && scene.isStale) {
    draw();
  }
  requestAnimationFrame(turn);
}

function changeSpeed(steps) {
  const select = byId('speed');
  select.selectedIndex = Math.min(Math.max(select.selectedIndex + steps, 0), SPEEDS.length - 1);
}

/// To the start of the next leg, or of the one before.
function hop(direction) {
  const starts = [].concat(...shown.map((task) => task.legs.map((leg, i) => task.start_s + legTime(task, i))));
  const next = direction > 0 ? starts.find((t_s) => t_s > now_s + 1e-6) : starts.reverse().find((t_s) => t_s < now_s - 1e-6);
  setTime(next === undefined ? (direction > 0 ? duration_s : 0) : next);
}

function goToClosest() {
  let least = null;
  for (const task of shown) {
    if (task.clearance && (least === null || task.clearance.certified_m < least.clearance.certified_m)) least = task;
  }
  if (least !== null) setTime(least.start_s + clockTime(least, least.clearance.t_s));
}

/// Turns the camera around what it looks at, or brings it nearer.
function moveCamera(turn_rad, tilt_rad, factor) {
  if (scene === null) return;
  const offset = scene.camera.position.clone().sub(scene.controls.target);
  const sphere = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));
  sphere.theta += turn_rad;
  sphere.phi = Math.min(Math.max(sphere.phi + tilt_rad, 0.01), Math.PI - 0.01);
  sphere.radius *= factor;
  const turned = new THREE.Vector3().setFromSpherical(sphere);
  scene.camera.position.copy(scene.controls.target).add(new THREE.Vector3(turned.x, -turned.z, turned.y));
  scene.controls.update();
  scene.isStale = true;
}

const CANVAS_KEYS = {
  ArrowLeft: () => moveCamera(-0.1, 0, 1), ArrowRight: () => moveCamera(0.1, 0, 1),
  ArrowUp: () => moveCamera(0, -0.1, 1), ArrowDown: () => moveCamera(0, 0.1, 1),
  '+': () => moveCamera(0, 0, 0.85), '-': () => moveCamera(0, 0, 1 / 0.85)
};

const KEYS = {
  ' ': () => play(!plays),
  ArrowLeft: (event) => setTime(now_s - (event.shiftKey ? 10 : 1)),
  ArrowRight: (event) => setTime(now_s + (event.shiftKey ? 10 : 1)),
  Home: () => setTime(0), End: () => setTime(duration_s),
  '[': () => changeSpeed(-1), ']': () => changeSpeed(1),
  p: () => hop(-1), n: () => hop(1), c: goToClosest,
  1: () => frame(new THREE.Vector3(0, 0, 1)), 2: () => frame(new THREE.Vector3(0, -1, 0)), 3: () => frame(new THREE.Vector3(1, 0, 0)),
  0: () => frame(SLANT),
  f: () => { follows = !follows; },
  g: () => follow(!live.follows),
  l: () => { withLabels = !withLabels; if (scene !== null) scene.isStale = true; }
};

function pressed(event) {
  if (shown.length === 0) return;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const onCanvas = document.activeElement === byId('canvas'), onSelect = document.activeElement === byId('speed');
  const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (onSelect && name !== ' ') return;
  if (name === ' ' && document.activeElement.tagName === 'SUMMARY') return;
  const action = (onCanvas && CANVAS_KEYS[event.key]) || KEYS[name];
  if (!action) return;
  action(event);
  event.preventDefault();
}

function connectControls() {
  byId('play').addEventListener('click', () => play(!plays));
  byId('slider').addEventListener('input', () => setTime(Number(byId('slider').value)));
  document.addEventListener('keydown', pressed);
  document.addEventListener('keyup', (event) => { if (event.key === ' ' && document.activeElement === byId('play')) event.preventDefault(); });
  window.addEventListener('resize', () => { if (shown.length > 0) { resize(); draw(); } });
  byId('speed').append(...SPEEDS.map((speed) => element('option', {value: String(speed)}, speed + ' ×')));
  byId('canvas').addEventListener('dblclick', () => frame(SLANT));
}

/// The tasks' places on the page's clock.
function setClock() {
  duration_s = horizon_s = 0;
  for (const task of shown) {
    const rows = flownRows(task);
    task.start_s = duration_s;
    task.duration_s = rows === null ? task.price.time_s : rows[rows.length - 1][TIME];
    duration_s += task.duration_s;
    horizon_s = Math.max(duration_s, task.start_s + clockTime(task, task.price.time_s));
  }
  byId('slider').max = String(duration_s);
}

/// Shows what picture.c made.
function show(picture) {
  data = picture;
  shown = picture.tasks;
  tabled = -1;
  for (const id of ['view', 'controls', 'plots', 'foot']) byId(id).hidden = shown.length === 0;
  byId('title').textContent = document.title = data.title;
  if (shown.length === 0) {
    byId('headline').textContent = data.live ? 'No plan was heard yet.' : 'There is nothing to show.';
    return;
  }
  setClock();
  const fitting = SPEEDS.findIndex((speed) => duration_s / speed <= 30);
  byId('speed').selectedIndex = fitting < 0 ? SPEEDS.length - 1 : fitting;
  drawHead();
  scene = makeScene();
  if (scene !== null) drawFlown();
  resize();
  frame(SLANT);
  makePlots();
  setTime(0);
}

// ---- What happens meanwhile -----------------------------------------------------------------------------------------

const ROWS_KEPT = 8000;   // of a track; then every second one of the older half goes
const PLOTS_MS = 500;     // how often plots and ways are drawn anew, at most
const PLOTS_SHARE = 10;   // and they may take so small a part of the time

const live = {isOn: false, follows: true, isStale: false, arePlotsStale: false, plots_ms: 0, last: null, events: 0, gaps: 0, snapshots: 0, rows: {estimate: 0, truth: 0}, planners: [], execution: null};

const LINKS = ['no vehicle', 'vehicle silent', 'vehicle heard'];

function liveFacts(news) {
  return [
    {cells: ['now', `${news.state} to ${news.goal}, ${fixed(news.plan_time_s, 1)} s of the plan` + (news.clock_rate < 1 ? `, its clock at ${fixed(100 * news.clock_rate, 0)} %` : '')]},
    {cells: ['off the plan', `${millimetres(news.behind_m)} behind, ${millimetres(news.beside_m)} beside`]},
    {cells: ['so far', `${fixed(news.flown_s, 1)} s, ${fixed(news.impulse_Ns, 1)} N s, ${news.attempts} attempts`]},
    {cells: ['link', `${news.link_received} frames heard, ${news.link_lost} lost, silent for ${fixed(news.link_silence_s, 1)} s`]}
  ];
}

function drawPlanners() {
  const rows = live.planners.map((planner) => ({cells: [planner.planner_id.slice(0, 8), planner.version, planner.scalar, LINKS[planner.link] || 'unknown', String(planner.flights), String(planner.accepted), String(planner.waiting)]}));
  byId('bus').replaceChildren(element('h2', {}, 'Planners on the bus'),
    rows.length > 0 ? table(['planner', 'version', 'arithmetic', 'link', 'flights', 'plans', 'waiting'], rows) : element('p', {}, 'None was heard yet.'));
}

function takeRow(event) {
  const task = shown[shown.length - 1];
  if (!task || !task.flight) return;
  if (task.flight[event.track] === null) {
    task.flight[event.track] = {rows: []};
    drawHead();
  }
  const track = task.flight[event.track], rows = track.rows;
  Object.assign(track, event.held);
  if (rows.length > 0 && event.row[TIME] <= rows[rows.length - 1][TIME]) return;
  rows.push(event.row);
  live.rows[event.track]++;
  if (rows.length > ROWS_KEPT) track.rows = rows.filter((row, i) => i % 2 === 0 || i > ROWS_KEPT / 2);
}

function takeNews(news) {
  const task = shown[shown.length - 1];
  live.execution = news;
  if (!task || !task.flight) return;
  Object.assign(task.flight, {outcome: news.outcome, reason: news.reason, attempts: news.attempts, num_plans: news.num_plans, flown_s: news.flown_s, impulse_Ns: news.impulse_Ns});
  byId('title').textContent = news.outcome === 'under_way' ? 'A flight under way' : 'A flight: ' + news.outcome.replace('_', ' ');
  byId('headline').textContent = `${news.outcome === 'under_way' ? `${news.state}, for ${news.goal}` : news.outcome.replace('_', ' ')}: ` +
    `${fixed(news.flown_s, 1)} s and ${fixed(news.impulse_Ns, 1)} N s flown; planned: ${fixed(task.price.time_s, 1)} s and ${fixed(task.price.impulse_Ns, 1)} N s`;
}

function takeEvent(event, number) {
  live.events++;
  if (event.kind === 'snapshot') live.snapshots++;
  else if (live.last !== null && number !== live.last + 1) live.gaps += number - live.last - 1;
  live.last = number;
  if (event.planners) {
    live.planners = event.planners;
    drawPlanners();
  }
  if ((event.kind === 'snapshot' || event.kind === 'picture') && event.picture) show(Object.assign(event.picture, {live: true}));
  if (event.kind === 'row') takeRow(event);
  if (event.kind === 'unknown') byId('headline').textContent = 'A flight is under way whose plan was not heard: the watch must be there when it is made.';
  else if (event.execution) takeNews(event.execution);
  live.isStale = live.arePlotsStale = true;
}

/// Draws what came since, as often as frames come; plots and ways less often.
function drawLive(ms) {
  if (!(live.isStale || live.arePlotsStale) || shown.length === 0) return;
  const wasWhole = plots.length > 0 && plots[0].graph.xAxisRange()[1] >= horizon_s - 1e-6;
  setClock();
  if (live.arePlotsStale && ms > live.plots_ms) {
    live.arePlotsStale = false;
    const began_ms = performance.now();
    isZooming = true;
    for (const plot of plots) plot.graph.updateOptions(Object.assign({file: plot.rowsOf()}, wasWhole ? {dateWindow: [0, horizon_s]} : {}));
    isZooming = false;
    if (scene !== null) drawFlown();
    live.plots_ms = ms + Math.max(PLOTS_MS, PLOTS_SHARE * (performance.now() - began_ms));
  }
  if (live.follows && flownRows(shown[shown.length - 1]) !== null) setTime(duration_s);
  else draw();
  live.isStale = false;
}

function follow(yes) {
  live.follows = yes;
  byId('follow').setAttribute('aria-pressed', String(yes));
  live.isStale = true;
}

function watch() {
  live.isOn = true;
  byId('follow').hidden = false;
  follow(true);
  byId('follow').addEventListener('click', () => follow(!live.follows));
  byId('slider').addEventListener('input', () => follow(false));
  drawPlanners();
  const source = new EventSource('events');
  source.addEventListener('message', (message) => takeEvent(JSON.parse(message.data), Number(message.lastEventId)));
  source.addEventListener('open', () => { byId('lost').hidden = true; });
  source.addEventListener('error', () => { byId('lost').hidden = false; });
}

connectControls();
data = JSON.parse(byId('data').textContent);
show(data);
if (data.live) watch();
requestAnimationFrame(turn);

/// What whoever tests or scripts the page can read and do.
window.ssv = {
  state() {
    const told = {events: live.events, gaps: live.gaps, snapshots: live.snapshots, rows: Object.assign({}, live.rows), planners: live.planners.length, execution: live.execution, follows: live.follows};
    if (shown.length === 0) return {live: told, tasks: 0};
    const state = stateAt(now_s), X = scene === null ? state.X_IS : {p: scene.vehicle.position, q: scene.vehicle.quaternion};
    return {
      live: told, tasks: shown.length, time_s: now_s, duration_s, task: state.task, leg: state.leg, mated: state.mated, docked: state.docked, plays,
      speed: Number(byId('speed').value), has_scene: scene !== null,
      X_IS: [X.p.x, X.p.y, X.p.z, X.q.w, X.q.x, X.q.y, X.q.z],
      X_IB: state.beams.map((beam) => [beam.p.x, beam.p.y, beam.p.z, beam.q.w, beam.q.x, beam.q.y, beam.q.z]),
      plan_s: state.plan_s, u_N: state.u_N,
      predicted: state.predicted ? [...state.predicted.p.toArray(), state.predicted.q.w, state.predicted.q.x, state.predicted.q.y, state.predicted.q.z] : null,
      estimate: state.estimate ? state.estimate.p.toArray() : null,
      arrows_m: scene === null ? [] : scene.arrows.map((one) => one.visible ? one.scale.z : 0),
      plot_times_s: plots.map((plot) => plot.graph.toDataXCoord(parseFloat(plot.line.style.left) - plot.graph.graphDiv.parentNode.offsetLeft)),
      plot_range_s: plots.length > 0 ? plots[0].graph.xAxisRange() : [],
      near: state.near,
      closest_is_red: scene !== null && scene.closest.visible,
      camera_m: scene === null ? [] : scene.camera.position.toArray(),
      in_view: scene === null ? [] : scene.points.map((p) => { const q = p.clone().project(scene.camera); return Math.max(Math.abs(q.x), Math.abs(q.y)); })
    };
  },
  setTime
};

})();
