// Scattered light as a body: its distance from the centre is f.
import * as three from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { type Direction, type Side, angles, direction } from "../core.js";
import { FILES, RAMPS, STEPS, type Scale } from "../colours.js";
import { element } from "../elements.js";
import type { Seen } from "../measured.js";
import type { Page } from "../page.js";
import type { Query, Subject } from "../subject.js";

const VERTEX = /* glsl */ `
attribute float f;
uniform float top;
uniform float decades;
uniform bool isLog;
varying float t;
varying vec3 place;
void main() {
    float share = f / top;
    t = isLog ? (share > 0.0 ? 1.0 + log(share) / (2.302585093 * decades) : 0.0) : share;
    t = clamp(t, 0.0, 1.0);
    vec4 seen = modelViewMatrix * vec4(position * t, 1.0);
    place = seen.xyz;
    gl_Position = projectionMatrix * seen;
    gl_PointSize = 3.5;
}`;

const FRAGMENT = /* glsl */ `
uniform sampler2D ramp;
uniform vec3 tint;
uniform float tinted;
uniform float opacity;
varying float t;
varying vec3 place;
void main() {
    vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
    vec3 colour = mix(texture2D(ramp, vec2(t, 0.5)).rgb, tint, tinted);
    gl_FragColor = vec4(colour * (0.55 + 0.45 * abs(normal.z)), opacity);
}`;

/// A measured point, dark in a light rim: seen on every colour.
const DOT = /* glsl */ `
void main() {
    float r = length(gl_PointCoord - 0.5);
    gl_FragColor = vec4(vec3(r > 0.32 ? 1.0 : 0.1), 1.0);
}`;

/// Radius at which the light's handle is.
const HANDLE = 1.12;
const NEAR = 22;

/// How fine a lobe is.
export interface Quality {
    finest: number;
    samples: number;
}

/// A lobe of one file on one side.
interface Body {
    mesh: three.Mesh<three.BufferGeometry, three.ShaderMaterial>;
    directions: Float32Array;
    values: Float32Array;
    triangles: Uint32Array;
}

export class LobePanel {
    readonly root: HTMLElement;
    readonly #page: Page;
    readonly #canvas = element("canvas", { tabIndex: 0 });
    readonly #renderer: three.WebGLRenderer | null = null;
    readonly #scene = new three.Scene();
    readonly #camera = new three.PerspectiveCamera(34, 1, 0.1, 20);
    readonly #controls: OrbitControls | null = null;
    readonly #bodies: Body[] = [];
    readonly #light = new three.Mesh(new three.SphereGeometry(0.045, 24, 16), new three.MeshBasicMaterial({ color: 0xffd84d }));
    readonly #ray = line(0xffd84d);
    readonly #pointer = line(0xffffff);
    readonly #texture = new three.DataTexture(new Uint8Array(4 * STEPS), STEPS, 1);
    readonly #dots: three.Points<three.BufferGeometry, three.ShaderMaterial>;
    #scale: Scale | null = null;
    #colours = "";
    #size = "";
    #dragging = false;

    constructor(page: Page) {
        this.#page = page;
        this.#dots = new three.Points(new three.BufferGeometry(), this.#material(DOT));
        this.#dots.frustumCulled = false;
        this.#canvas.setAttribute("aria-label", "Scattered light in three dimensions; drag the yellow ball to move the light, elsewhere to turn");
        this.root = element("section", { className: "panel lobe" }, this.#canvas);
        try {
            this.#renderer = new three.WebGLRenderer({ canvas: this.#canvas, antialias: true, alpha: true });
        } catch {
            this.root.append(element("p", { className: "note", textContent: "No WebGL here: the lobe is not drawn in three dimensions." }));
            return;
        }
        this.#camera.up.set(0, 0, 1);
        this.#camera.position.set(1.5, -2.7, 1.7);
        this.#controls = new OrbitControls(this.#camera, this.#canvas);
        this.#controls.enablePan = false;
        this.#controls.minDistance = 1.5;
        this.#controls.maxDistance = 8;
        this.#controls.addEventListener("change", () => page.redraw());
        this.#scene.add(...surroundings(), this.#dots, this.#light, this.#ray, this.#pointer);
        this.#canvas.addEventListener("pointerdown", (e) => this.#press(e), { capture: true });
        this.#canvas.addEventListener("pointermove", (e) => this.#move(e));
        this.#canvas.addEventListener("pointerup", () => this.#release());
        this.#canvas.addEventListener("pointercancel", () => this.#release());
        this.#canvas.addEventListener("pointerleave", () => page.hover(null));
    }

    /// Measured points at their values, as `show` scales them.
    points(seen: Iterable<Seen>): void {
        const all = [...seen];
        const count = all.reduce((sum, { values }) => sum + values.length, 0);
        const [directions, values] = [new Float32Array(3 * count), new Float32Array(count)];
        let at = 0;
        for (const points of all) {
            directions.set(points.directions, 3 * at);
            values.set(points.values, at);
            at += points.values.length;
        }
        const { geometry } = this.#dots;
        geometry.dispose();
        geometry.setAttribute("position", new three.BufferAttribute(directions, 3));
        geometry.setAttribute("f", new three.BufferAttribute(values, 1));
        geometry.setDrawRange(0, count);
    }

    /// Meshes of all files on these sides, with quads down to 2^−`finest` where `samples` crowd; the largest value.
    compute(query: Query, subjects: readonly Subject[], sides: readonly Side[], { finest, samples }: Quality): number {
        const compared = query.state.compare;
        const files = subjects.map((subject, file) => ({ subject, file })).filter(({ file }) =>
            subjects.length < 2 || (compared === "a" ? file === 0 : compared === "b" ? file === 1 : true));
        const wanted = files.flatMap(({ subject, file }) => sides.map((side) => ({ subject, file, side })));
        while (this.#bodies.length > wanted.length) this.#scene.remove(this.#bodies.pop()!.mesh);
        let largest = 0;
        wanted.forEach(({ subject, file, side }, n) => {
            const lobe = query.lobe(subject, side, finest, samples);
            const body = this.#bodies[n] ?? this.#add();
            body.directions = lobe.directions;
            body.values = lobe.values;
            body.triangles = lobe.triangles;
            lobe.free();
            const { geometry, material } = body.mesh;
            geometry.dispose();
            geometry.setAttribute("position", new three.BufferAttribute(body.directions, 3));
            geometry.setAttribute("f", new three.BufferAttribute(body.values, 1));
            geometry.setIndex(new three.BufferAttribute(body.triangles, 1));
            material.uniforms["tinted"]!.value = files.length > 1 ? 0.8 : 0;
            material.uniforms["tint"]!.value = new three.Color(FILES[file]).convertLinearToSRGB();
            // The second is a veil over the first.
            const veil = files.length > 1 && file === 1;
            material.uniforms["opacity"]!.value = veil ? 0.55 : 1;
            material.transparent = veil;
            material.depthWrite = !veil;
            for (const value of body.values) largest = Math.max(largest, value);
        });
        return largest;
    }

    show(query: Query, scale: Scale): void {
        this.#scale = scale;
        if (this.#colours !== query.state.colours) {
            this.#colours = query.state.colours;
            (this.#texture.image.data as Uint8Array).set(RAMPS[query.state.colours]);
            this.#texture.minFilter = this.#texture.magFilter = three.LinearFilter;
            this.#texture.needsUpdate = true;
        }
        for (const { material } of [...this.#bodies.map(({ mesh }) => mesh), this.#dots]) {
            Object.assign(material.uniforms["top"]!, { value: scale.top });
            Object.assign(material.uniforms["decades"]!, { value: scale.decades });
            Object.assign(material.uniforms["isLog"]!, { value: scale.log });
        }
    }

    /// With `share` of the pixels along a side.
    draw(query: Query, hovered: Direction | null, share: number): void {
        if (!this.#renderer) return;
        const { clientWidth: width, clientHeight: height } = this.root;
        const density = share * Math.min(devicePixelRatio || 1, 2);
        const size = [width, height, density].join();
        // A canvas that is given a size, even the one that it has, is made anew.
        if (size !== this.#size) {
            this.#size = size;
            this.#renderer.setPixelRatio(density);
            this.#renderer.setSize(width, height, false);
        }
        this.#camera.aspect = width / Math.max(1, height);
        this.#camera.updateProjectionMatrix();
        const wi = new three.Vector3(...query.wi);
        this.#light.position.copy(wi).multiplyScalar(HANDLE);
        stretch(this.#ray, wi, HANDLE);
        this.#pointer.visible = hovered !== null;
        if (hovered) stretch(this.#pointer, new three.Vector3(...hovered), 1.02);
        this.#renderer.render(this.#scene, this.#camera);
        // Where the light is, for whoever reads the page otherwise than by eye.
        this.#canvas.dataset["light"] = this.#lightInPanel().map(Math.round).join();
    }

    #lightInPanel(): [number, number] {
        const { clientWidth: width, clientHeight: height } = this.#canvas;
        const seen = this.#light.position.clone().project(this.#camera);
        return [((seen.x + 1) / 2) * width, ((1 - seen.y) / 2) * height];
    }

    #material(fragment: string): three.ShaderMaterial {
        return new three.ShaderMaterial({
            vertexShader: VERTEX,
            fragmentShader: fragment,
            side: three.DoubleSide,
            uniforms: {
                top: { value: 1 },
                decades: { value: 3 },
                isLog: { value: true },
                ramp: { value: this.#texture },
                tint: { value: new three.Color() },
                tinted: { value: 0 },
                opacity: { value: 1 },
            },
        });
    }

    #add(): Body {
        const mesh = new three.Mesh(new three.BufferGeometry(), this.#material(FRAGMENT));
        mesh.frustumCulled = false;
        this.#scene.add(mesh);
        const body = { mesh, directions: new Float32Array(), values: new Float32Array(), triangles: new Uint32Array() };
        this.#bodies.push(body);
        return body;
    }

    #aim(event: PointerEvent): three.Ray {
        const { left, top, width, height } = this.#canvas.getBoundingClientRect();
        const at = new three.Vector2(((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2);
        const caster = new three.Raycaster();
        caster.setFromCamera(at, this.#camera);
        return caster.ray;
    }

    #press(event: PointerEvent): void {
        const { left, top } = this.#canvas.getBoundingClientRect();
        const [x, y] = this.#lightInPanel();
        if (Math.hypot(event.clientX - left - x, event.clientY - top - y) > NEAR) return;
        this.#dragging = true;
        this.#controls!.enabled = false;
        this.#canvas.setPointerCapture(event.pointerId);
        event.preventDefault();
    }

    #release(): void {
        this.#dragging = false;
        if (this.#controls) this.#controls.enabled = true;
    }

    #move(event: PointerEvent): void {
        const ray = this.#aim(event);
        if (this.#dragging) {
            const w = onSphere(ray, HANDLE);
            this.#page.drag(angles([w.x, w.y, w.z]));
        } else if (event.buttons === 0) {
            this.#page.hover(this.#hit(ray));
        }
    }

    /// The direction in which a ray meets a body first.
    #hit(ray: three.Ray): Direction | null {
        const scale = this.#scale;
        if (!scale) return null;
        let nearest = Infinity;
        let found: three.Vector3 | null = null;
        const [a, b, c, hit] = [new three.Vector3(), new three.Vector3(), new three.Vector3(), new three.Vector3()];
        for (const { directions, values, triangles } of this.#bodies) {
            const radii = values.map((value) => scale.at(value));
            const corner = (n: number, out: three.Vector3) => out.fromArray(directions, 3 * n).multiplyScalar(radii[n]!);
            for (let k = 0; k < triangles.length; k += 3) {
                corner(triangles[k]!, a);
                corner(triangles[k + 1]!, b);
                corner(triangles[k + 2]!, c);
                if (ray.intersectTriangle(a, b, c, false, hit)) {
                    const distance = hit.distanceToSquared(ray.origin);
                    if (distance < nearest) [nearest, found] = [distance, hit.clone()];
                }
            }
        }
        if (!found || found.length() < 1e-6) return null;
        found.normalize();
        return [found.x, found.y, found.z];
    }
}

function line(colour: number): three.Line {
    const geometry = new three.BufferGeometry().setFromPoints([new three.Vector3(), new three.Vector3()]);
    return new three.Line(geometry, new three.LineBasicMaterial({ color: colour }));
}

function stretch(line: three.Line, to: three.Vector3, length: number): void {
    const place = line.geometry.getAttribute("position");
    place.setXYZ(1, to.x * length, to.y * length, to.z * length);
    place.needsUpdate = true;
    line.geometry.computeBoundingSphere();
}

/// Where a ray meets the sphere, or the point of the sphere that it passes nearest.
function onSphere(ray: three.Ray, radius: number): three.Vector3 {
    const sphere = new three.Sphere(new three.Vector3(), radius);
    const met = ray.intersectSphere(sphere, new three.Vector3());
    return (met ?? ray.closestPointToPoint(sphere.center, new three.Vector3())).normalize();
}

/// A letter that faces the eye.
function label(text: string): three.Sprite {
    const canvas = element("canvas", { width: 64, height: 64 });
    const pen = canvas.getContext("2d")!;
    pen.font = "bold 44px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillStyle = "#8890a0";
    pen.fillText(text, 32, 32);
    const sprite = new three.Sprite(new three.SpriteMaterial({ map: new three.CanvasTexture(canvas) }));
    sprite.scale.setScalar(0.16);
    return sprite;
}

/// Rings at 30, 60 and 90 degrees, the specimen's plane and its axes.
function surroundings(): three.Object3D[] {
    const grey = (opacity: number) => new three.LineBasicMaterial({ color: 0x8890a0, transparent: true, opacity });
    const loop = (points: three.Vector3[], opacity: number) =>
        new three.LineLoop(new three.BufferGeometry().setFromPoints(points), grey(opacity));
    const ring = (theta: number) => Array.from({ length: 96 }, (_, k) => new three.Vector3(...direction([theta, (k * 360) / 96])));
    const rings = [30, 60, 90, 120, 150].map((theta) => loop(ring(theta), theta === 90 ? 0.9 : 0.25));
    const meridians = [0, 45, 90, 135].map((phi) => loop(
        Array.from({ length: 96 }, (_, k) => {
            const theta = (k * 360) / 96;
            const [x, y, z] = direction([theta, phi]);
            return new three.Vector3(x, y, z);
        }), 0.18));
    const axes = ([[1.25, 0, 0], [0, 1.25, 0], [0, 0, 1.25]] as const).map(([x, y, z], n) => {
        const axis = line([0xd0605e, 0x59a14f, 0x4e79a7][n]!);
        stretch(axis, new three.Vector3(x, y, z), 1);
        const name = label("XYZ"[n]!);
        name.position.set(x, y, z).multiplyScalar(1.07);
        axis.add(name);
        return axis;
    });
    return [...rings, ...meridians, ...axes];
}

