/** The picture: the sheet as a lit surface with its yarns, holes where segments have failed, and the projectile. Metres. */
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, DirectionalLight, DoubleSide, Group, HemisphereLight, LineBasicMaterial, LineSegments, Mesh,
  GreaterDepth, MeshBasicMaterial, MeshLambertMaterial, MeshPhongMaterial, PerspectiveCamera, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Frame } from "./messages";
import { ConvexGeometry } from "three/addons/geometries/ConvexGeometry.js";
import { extent, profile, vertices } from "./scene";
import type { Choices } from "./scene";

export type Colouring = "stretch" | "damage";
export type Side = "oblique" | "side" | "front" | "back";

/** From linen to dark red; the first is yarn without load. The page's colour bar has the same. */
export const COLOURS = ["#d6d3cb", "#f2cf5b", "#f28e2b", "#d1352b", "#6b0f2e"];
const STOPS = COLOURS.map((colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16) / 255));
/** Colours in finer steps, as linear light, which the renderer wants. */
const TABLE = Array.from({ length: 256 }, (_, k) => {
  const whole = Math.min(3, Math.floor((k / 255) * 4));
  const rest = (k / 255) * 4 - whole;
  return [0, 1, 2].map((c) => ((STOPS[whole]?.[c] ?? 0) * (1 - rest) + (STOPS[whole + 1]?.[c] ?? 0) * rest) ** 2.2);
}).flat();

const VIEWS: Record<Side, [number, number, number]> = { oblique: [0.62, -1.05, 0.72], side: [0, -1, 0.03], back: [0, -0.02, 1], front: [0.25, -0.55, -1] };
/** Yarns drawn over the surface along one side of the sheet, at most. */
const MOST_YARNS = 120;

export class View {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(32, 1, 1e-3, 20);
  private readonly controls: OrbitControls;
  private readonly body = new Group();
  private readonly cloth = new Mesh(new BufferGeometry(), new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, flatShading: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
  private readonly yarns = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true }));
  private nodes: [number, number] = [0, 0];
  /** Corners of the box about the sheet at rest, its middle, and the largest half of its lengths. */
  private corners: Vector3[] = [];
  private readonly middle = new Vector3();
  private half = 0;
  private asked = false;

  /** Throws where the browser has no WebGL. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    // To ask whether a shader is sound means to wait for it.
    this.renderer.debug.checkShaderErrors = false;
    this.camera.up.set(0, 0, 1);
    const sun = new DirectionalLight(0xffffff, 2.1);
    sun.position.set(-0.55, -0.5, 0.8);
    const other = new DirectionalLight(0xffffff, 0.9);
    other.position.set(0.6, 0.3, -0.8);
    this.scene.add(new HemisphereLight(0xffffff, 0x8d97a5, 1.15), sun, other, this.cloth, this.yarns, this.body);
    this.cloth.frustumCulled = this.yarns.frustumCulled = false;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** A new sheet and body. The camera moves only if the sheet has another size; then it looks from the side `view`. */
  make(nodes: [number, number], choices: Choices, view: Side): void {
    this.nodes = nodes;
    const count = nodes[0] * nodes[1];
    for (const thing of [this.cloth, this.yarns]) {
      thing.geometry.dispose();
      thing.geometry = new BufferGeometry();
    }
    const positions = new BufferAttribute(new Float32Array(3 * count), 3);
    const colours = new BufferAttribute(new Float32Array(3 * count), 3);
    const darker = new BufferAttribute(new Float32Array(3 * count), 3);
    this.cloth.geometry.setAttribute("position", positions).setAttribute("color", colours);
    this.yarns.geometry.setAttribute("position", positions).setAttribute("color", darker);
    this.cloth.geometry.setIndex(new BufferAttribute(new Uint32Array(6 * count), 1));
    this.yarns.geometry.setIndex(new BufferAttribute(new Uint32Array(4 * count), 1));
    for (const part of this.body.children) if (part instanceof Mesh) part.geometry.dispose();
    this.body.clear();
    const form = solid(choices);
    const steel = new MeshPhongMaterial({ color: 0x5b7285, specular: 0x9fb0c0, shininess: 50, flatShading: choices.shape === "disc_sector" || choices.shape === "fsp" });
    // What the cloth hides of it shines through.
    const hidden = new MeshBasicMaterial({ color: 0x2b4f73, transparent: true, opacity: 0.16, depthFunc: GreaterDepth, depthWrite: false });
    this.body.add(new Mesh(form, steel), new Mesh(form, hidden));
    // A little smaller than it is: between the nodes that touch it the cloth is drawn straight, and would lie within it.
    this.body.scale.setScalar(0.98);
    const [least, most] = extent(choices).map((corner) => new Vector3(...corner)) as [Vector3, Vector3];
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => new Vector3(k & 1 ? most.x : least.x, k & 2 ? most.y : least.y, k & 4 ? most.z : least.z));
    if (corners.some((corner, k) => corner.distanceTo(this.corners[k] ?? new Vector3(Infinity)) > 1e-9)) {
      this.corners = corners;
      this.middle.addVectors(least, most).divideScalar(2);
      this.half = Math.max(...most.clone().sub(least).toArray()) / 2;
      this.resize();
      this.look(view);
    }
  }

  look(side: Side): void {
    const [x, y, z] = VIEWS[side];
    this.controls.target.copy(this.middle).z -= side === "oblique" ? 0.06 * this.half : 0;
    // So far away that all corners are in the picture.
    const fits = (far: number): boolean => {
      this.camera.position.set(x * far, y * far, z * far).add(this.controls.target);
      this.camera.lookAt(this.controls.target);
      this.camera.updateMatrixWorld();
      const corners = this.corners.map((corner) => corner.clone().project(this.camera));
      return corners.every((corner) => Math.max(Math.abs(corner.x), Math.abs(corner.y)) < 0.94);
    };
    let far = this.half;
    while (!fits(far) && far < 20 * this.half) far *= 1.02;
    this.controls.update();
    this.draw();
  }

  /** strain: the one at which yarn begins to fail. */
  show(frame: Frame, colouring: Colouring, strain: number): void {
    const attribute = (thing: Mesh | LineSegments, name: string): BufferAttribute => thing.geometry.getAttribute(name) as BufferAttribute;
    const [positions, colours, darker] = [attribute(this.cloth, "position"), attribute(this.cloth, "color"), attribute(this.yarns, "color")];
    (positions.array as Float32Array).set(frame.positions);
    const [values, scale] = colouring === "stretch" ? [frame.strain, 255 / strain] : [frame.damage, 255];
    for (let node = 0; node < values.length; node++) {
      // What has any damage differs from what has none.
      const value = (values[node] ?? 0) * scale;
      const at = 3 * Math.min(255, Math.max(0, colouring === "damage" && value > 0 ? 40 + 0.84 * value : value) | 0);
      for (let c = 0; c < 3; c++) {
        const part = TABLE[at + c] ?? 0;
        colours.array[3 * node + c] = part;
        darker.array[3 * node + c] = 0.36 * part;
      }
    }
    for (const changed of [positions, colours, darker]) changed.needsUpdate = true;
    this.connect(frame.failed);
    const { position, orientation } = frame.motion;
    const [w = 1, x = 0, y = 0, z = 0] = orientation;
    this.body.position.set(position[0] ?? 0, position[1] ?? 0, position[2] ?? 0);
    this.body.quaternion.set(x, y, z, w);
    this.draw();
  }

  /** Surface where all four segments of a mesh are alive, and yarns: all at a hole, and as many elsewhere as can be told apart. */
  private connect(failed: Uint8Array): void {
    const [nx, ny] = this.nodes;
    const [faces, lines] = [this.cloth.geometry.getIndex(), this.yarns.geometry.getIndex()];
    if (!faces || !lines) return;
    const [face, line] = [faces.array as Uint32Array, lines.array as Uint32Array];
    // Segments of a row: of a ring as many as nodes.
    const across = (failed.length - nx * (ny - 1)) / ny;
    const upright = across * ny;
    const stride = Math.ceil(Math.max(nx, ny) / MOST_YARNS);
    const open = (i: number, j: number): boolean => {
      if (i < 0 || j < 0 || i >= across || j >= ny - 1) return false;
      const [low, column] = [j * across + i, upright + j * nx];
      return ((failed[low] ?? 0) | (failed[low + across] ?? 0) | (failed[column + i] ?? 0) | (failed[column + ((i + 1) % nx)] ?? 0)) !== 0;
    };
    let [f, l] = [0, 0];
    for (let j = 0; j < ny; j++) {
      for (let i = 0; i < nx; i++) {
        const node = j * nx + i;
        const next = j * nx + ((i + 1) % nx);
        const torn = open(i, j);
        if (i < across && j < ny - 1 && !torn) {
          face.set([node, next, next + nx, node, next + nx, node + nx], f);
          f += 6;
        }
        if (i < across && !failed[j * across + i] && (j % stride === 0 || torn || open(i, j - 1))) {
          line[l++] = node;
          line[l++] = next;
        }
        if (j < ny - 1 && !failed[upright + node] && (i % stride === 0 || torn || open(i === 0 && across === nx ? nx - 1 : i - 1, j))) {
          line[l++] = node;
          line[l++] = node + nx;
        }
      }
    }
    this.cloth.geometry.setDrawRange(0, f);
    this.yarns.geometry.setDrawRange(0, l);
    faces.needsUpdate = lines.needsUpdate = true;
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Waits until the graphics processor has drawn what it was told to. A slow one would else be told more and more. */
  async drawn(): Promise<void> {
    const nextPicture = (): Promise<number> => new Promise(requestAnimationFrame);
    await nextPicture();
    const context = this.renderer.getContext();
    if (!(context instanceof WebGL2RenderingContext)) return;
    const fence = context.fenceSync(context.SYNC_GPU_COMMANDS_COMPLETE, 0);
    context.flush();
    while (fence && context.getSyncParameter(fence, context.SYNC_STATUS) === context.UNSIGNALED) await nextPicture();
    context.deleteSync(fence);
  }

  /** At the browser's next picture, once. */
  private draw(): void {
    if (this.asked || this.half === 0) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}

/** The body about its centre of mass, in its own axes. */
function solid(choices: Choices): BufferGeometry {
  const [radius, length] = [1e-3 * choices.radius, 1e-3 * choices.length];
  if (choices.shape === "sphere") return new SphereGeometry(radius, 48, 32);
  if (choices.shape === "cylinder") return new CylinderGeometry(radius, radius, length, 64).rotateX(Math.PI / 2);
  if (choices.shape === "box") return new BoxGeometry(1e-3 * choices.edgeX, 1e-3 * choices.edgeY, length);
  if (choices.shape === "fsp") return new ConvexGeometry(vertices(choices).map((corner) => new Vector3(...corner)));
  const corners = profile(choices);
  const points: number[] = [];
  const at = (k: number, z: number): number[] => [...(corners[k % corners.length] ?? [0, 0]), z];
  corners.forEach((_, k) => {
    const [low, high] = [-length / 2, length / 2];
    points.push(...at(k, low), ...at(k + 1, low), ...at(k + 1, high), ...at(k, low), ...at(k + 1, high), ...at(k, high));
    if (k === 0 || k === corners.length - 1) return;
    points.push(...at(0, high), ...at(k, high), ...at(k + 1, high), ...at(0, low), ...at(k + 1, low), ...at(k, low));
  });
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.computeVertexNormals();
  return geometry;
}
