// The 3D view of a room: robots whose shape and joints come from their model, moved by the poses that they report.
import {
  AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, DirectionalLight,
  Group, HemisphereLight, Line, LineBasicMaterial, LineDashedMaterial, LineSegments, Mesh, MeshLambertMaterial,
  PerspectiveCamera, PlaneGeometry, Quaternion, Scene, SphereGeometry, SRGBColorSpace, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const PLANE = 0, SPHERE = 2, CAPSULE = 3, CYLINDER = 5, BOX = 6; // as in MuJoCo's mjtGeom
const UP = new Vector3(0, 0, 1);
const quaternion = ([w, x, y, z]) => new Quaternion(x, y, z, w);

// ---------------------------------------------------------------- shapes
function readShape(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  if (head.version !== 1) throw new Error("a shape of another version");
  const base = 4 + length;
  const padded = (bytes) => bytes + ((4 - (bytes % 4)) % 4);
  const meshes = head.meshes.map((mesh) => {
    const raw = new Uint16Array(buffer, base + mesh.at, 3 * mesh.vertices);
    const Index = mesh.bytes === 2 ? Uint16Array : Uint32Array;
    const faces = new Index(buffer, base + mesh.at + padded(6 * mesh.vertices), 3 * mesh.faces);
    const points = new Float32Array(raw.length);
    for (let i = 0; i < raw.length; i++) points[i] = mesh.low[i % 3] + (raw[i] / 65535) * (mesh.high[i % 3] - mesh.low[i % 3]);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    geometry.setIndex(new BufferAttribute(faces, 1));
    geometry.computeVertexNormals();
    return geometry;
  });
  return { head, meshes };
}

function primitive(kind, size) {
  if (kind === PLANE) return new PlaneGeometry(2 * (size[0] || 10), 2 * (size[1] || 10));
  if (kind === SPHERE) return new SphereGeometry(size[0], 24, 16);
  if (kind === BOX) return new BoxGeometry(2 * size[0], 2 * size[1], 2 * size[2]);
  if (kind === CAPSULE) return new CapsuleGeometry(size[0], 2 * size[1], 6, 16).rotateX(Math.PI / 2);
  if (kind === CYLINDER) return new CylinderGeometry(size[0], size[0], 2 * size[1], 28).rotateX(Math.PI / 2);
  return null;
}

function solid(geom, meshes, floor) {
  const geometry = geom.mesh === undefined ? primitive(geom.kind, geom.size) : meshes[geom.mesh];
  if (!geometry) return null;
  const [red, green, blue, alpha] = geom.kind === PLANE && floor ? [...floor, 1] : geom.colour;
  const color = new Color().setRGB(red, green, blue, SRGBColorSpace);
  const made = new Mesh(geometry, new MeshLambertMaterial({ color, transparent: alpha < 1, opacity: alpha, depthWrite: alpha === 1 }));
  made.position.set(...geom.at);
  made.quaternion.copy(quaternion(geom.turned));
  return made;
}

// A robot: its bodies as a tree, whose joints turn by the angles of the motors.
class Robot {
  constructor({ head, meshes }) {
    this.root = new Group();
    this.joints = [];
    const groups = head.bodies.map(() => new Group());
    head.bodies.forEach((body, n) => {
      const group = groups[n];
      if (body.parent < 0) { this.root.add(group); return; }
      group.position.set(...body.at);
      group.quaternion.copy(quaternion(body.turned));
      groups[body.parent].add(group);
      if (body.joint) {
        this.joints.push({
          group, motor: body.joint.motor, axis: new Vector3(...body.joint.axis), pivot: new Vector3(...body.joint.pivot),
          at: new Vector3(...body.at), rest: quaternion(body.turned),
        });
      }
    });
    for (const geom of head.geoms) {
      const one = solid(geom, meshes);
      if (one) groups[geom.body].add(one);
    }
    this.height = head.bodies[0].at[2] || 0.3;
    this.turn = new Quaternion();
    this.offset = new Vector3();
  }

  place([x, y, yaw], body) {
    const heading = new Quaternion().setFromAxisAngle(UP, yaw);
    if (!body || body.length < 5) {
      this.root.position.set(x, y, this.height);
      this.root.quaternion.copy(heading);
      return;
    }
    this.root.position.set(x, y, body[0]);
    this.root.quaternion.copy(heading).multiply(quaternion(body.slice(1, 5)).normalize());
    for (const joint of this.joints) {
      this.turn.setFromAxisAngle(joint.axis, body[5 + joint.motor] || 0);
      joint.group.quaternion.copy(joint.rest).multiply(this.turn);
      // it turns around its pivot, which is seldom the body's origin
      this.offset.copy(joint.pivot).applyQuaternion(this.turn).negate().add(joint.pivot).applyQuaternion(joint.rest);
      joint.group.position.copy(joint.at).add(this.offset);
    }
  }
}

// ---------------------------------------------------------------- the view
// A floor with a line every metre, for a robot whose room is not known in 3D. Short lines: some renderers drop those that
// pass the camera.
function floor(dark) {
  const half = 6, points = [];
  for (let n = -half; n <= half; n++) {
    for (let m = -half; m < half; m++) {
      points.push(new Vector3(n, m, 0.004), new Vector3(n, m + 1, 0.004), new Vector3(m, n, 0.004), new Vector3(m + 1, n, 0.004));
    }
  }
  const lines = new LineBasicMaterial({ color: dark ? 0x4a5664 : 0xaeb8c2 });
  const ground = new Mesh(new PlaneGeometry(2 * half, 2 * half), new MeshLambertMaterial({ color: dark ? 0x2a323c : 0xd5dbe1 }));
  return [ground, new LineSegments(new BufferGeometry().setFromPoints(points), lines)];
}

class Path {
  constructor(scene, dark) {
    this.scene = scene;
    this.plan = new Line(new BufferGeometry(), new LineDashedMaterial({ color: dark ? 0xffffff : 0x303844, dashSize: 0.12, gapSize: 0.08 }));
    this.trail = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0x1565c0 }));
    scene.add(this.plan, this.trail);
  }

  set(plan, trail) {
    for (const [line, points, height] of [[this.plan, plan, 0.012], [this.trail, trail, 0.016]]) {
      line.geometry.dispose();
      line.geometry = new BufferGeometry().setFromPoints(points.map(([x, y]) => new Vector3(x, y, height)));
      line.computeLineDistances();
      line.visible = points.length > 1;
    }
  }
}

// Open the view in an element. `shapes`: the address of each robot's shape, `follow`: the robot that the camera follows.
export async function openView(stage, shapes, follow) {
  const read = new Map();
  for (const [name, address] of shapes) {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error("the shape of a robot could not be loaded");
    read.set(name, readShape(await answer.arrayBuffer()));
  }
  const renderer = new WebGLRenderer({ antialias: true }); // throws without WebGL
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const scene = new Scene();
  scene.background = new Color(dark ? 0x1d232b : 0xe9edf1);
  scene.add(new HemisphereLight(0xffffff, 0x9a8f80, 2), new AmbientLight(0xffffff, 0.3));
  const sun = new DirectionalLight(0xffffff, 1.6);
  sun.position.set(2, -3, 5);
  scene.add(sun);

  const robots = new Map(), paths = new Map();
  let furnished = false;
  for (const [name, shape] of read) {
    if (!furnished && shape.head.room.length) {
      for (const geom of shape.head.room) {
        const one = solid(geom, shape.meshes, shape.head.floor);
        if (one) scene.add(one);
      }
      furnished = true;
    }
    const robot = new Robot(shape);
    robot.root.visible = false;
    robots.set(name, robot);
    paths.set(name, new Path(scene, dark));
    scene.add(robot.root);
  }
  if (!furnished) scene.add(...floor(dark));

  const camera = new PerspectiveCamera(42, 1, 0.05, 80);
  camera.up.copy(UP);
  camera.position.set(-2, -2.3, 1.6);
  const canvas = renderer.domElement;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `3D view of the room; drag to look around`);
  stage.append(canvas);
  const controls = new OrbitControls(camera, canvas);
  controls.target.set(0, 0, 0.25);
  controls.maxPolarAngle = Math.PI / 2 - 0.03;
  controls.minDistance = 0.8;
  controls.maxDistance = 14;

  let asked = 0, found = false;
  const draw = () => {
    asked = 0;
    const followed = robots.get(follow) || robots.values().next().value;
    if (followed && followed.root.visible) {
      const wanted = new Vector3(followed.root.position.x, followed.root.position.y, 0.3);
      const step = wanted.sub(controls.target).multiplyScalar(found ? 0.12 : 1);
      found = true;
      if (step.lengthSq() > 1e-8) { controls.target.add(step); camera.position.add(step); redraw(); }
    }
    controls.update();
    renderer.render(scene, camera);
  };
  const redraw = () => { if (!asked) asked = requestAnimationFrame(draw); };
  const resize = () => {
    const wide = stage.clientWidth, high = canvas.clientHeight || 360;
    renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    renderer.setSize(wide, high, false);
    camera.aspect = wide / high;
    camera.updateProjectionMatrix();
    redraw();
  };
  controls.addEventListener("change", redraw);
  const watching = new ResizeObserver(resize);
  watching.observe(stage);
  resize();

  return {
    place(name, pose, body) {
      const robot = robots.get(name);
      if (!robot) return;
      robot.root.visible = true;
      robot.place(pose, body);
      redraw();
    },
    path(name, plan, trail) {
      const path = paths.get(name);
      if (path) { path.set(plan, trail); redraw(); }
    },
    follow(name) {
      follow = name;
      redraw();
    },
    close() {
      watching.disconnect();
      cancelAnimationFrame(asked);
      controls.dispose();
      scene.traverse((one) => { if (one.geometry) one.geometry.dispose(); if (one.material) one.material.dispose(); });
      renderer.dispose();
      canvas.remove();
    },
  };
}
