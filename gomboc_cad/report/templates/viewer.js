"use strict";
// The product in space: turned by pointer or keys, parts hidden, cut open, the surface coloured by a field.
(() => {
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const root = document.getElementById("viewer");
  const canvas = root.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
  if (!gl) return; // The still picture stays.

  const VERTEX = `#version 300 es
    in vec3 position, normal, tint;
    uniform mat4 projection, view, pose;
    uniform vec4 color;
    uniform bool tinted;
    uniform float swell;
    centroid out vec3 place, facing, shade;
    void main() {
      vec4 world = pose * vec4(position, 1.0);
      facing = mat3(pose) * normal;
      world.xyz += swell * facing;
      place = world.xyz;
      shade = tinted ? tint : color.rgb;
      gl_Position = projection * view * world;
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    centroid in vec3 place, facing, shade;
    uniform vec4 color;
    uniform vec3 eye, cut;
    uniform bool opened;
    out vec4 pixel;
    void main() {
      if (opened && dot(place, cut) > 0.0) discard;
      vec3 n = normalize(gl_FrontFacing ? facing : -facing), to = normalize(eye - place);
      vec3 light = normalize(to + vec3(0.0, 0.0, 0.7));
      float bright = 0.42 + 0.5 * abs(dot(n, light)) + 0.08 * n.z;
      vec3 seen = shade * bright * (gl_FrontFacing ? 1.0 : 0.75);
      pixel = vec4(seen * color.a, color.a);
    }`;

  // ---- data

  function integers(packed) {
    const text = atob(packed.base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return packed.dtype === "uint16" ? new Uint16Array(bytes.buffer) : bytes;
  }

  function numbers(packed) {
    return Float32Array.from(integers(packed), (n) => packed.offset + packed.scale * n);
  }

  function normalsOf(points, faces) {
    const sums = new Float32Array(points.length);
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
      const u = [0, 1, 2].map((k) => points[b + k] - points[a + k]);
      const v = [0, 1, 2].map((k) => points[c + k] - points[a + k]);
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      for (const corner of [a, b, c]) for (let k = 0; k < 3; k++) sums[corner + k] += n[k];
    }
    return sums; // Only their directions matter, but for the surface that is swollen.
  }

  function sphere(center, radius) {
    const rows = 16, columns = 32, points = [], faces = [];
    for (let i = 0; i <= rows; i++) for (let j = 0; j <= columns; j++) {
      const t = (Math.PI * i) / rows, p = (2 * Math.PI * j) / columns;
      points.push(center[0] + radius * Math.sin(t) * Math.cos(p), center[1] + radius * Math.sin(t) * Math.sin(p),
        center[2] + radius * Math.cos(t));
      if (i < rows && j < columns) {
        const at = i * (columns + 1) + j;
        faces.push(at, at + columns + 1, at + 1, at + 1, at + columns + 1, at + columns + 2);
      }
    }
    return { points: new Float32Array(points), faces: new Uint32Array(faces) };
  }

  function cross(center, length, width) {
    const points = [], faces = [];
    for (let axis = 0; axis < 3; axis++) {
      const half = [width, width, width];
      half[axis] = length;
      const first = points.length / 3;
      for (let k = 0; k < 8; k++) for (let d = 0; d < 3; d++) points.push(center[d] + (k & (1 << d) ? half[d] : -half[d]));
      for (const f of [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5])
        faces.push(first + f);
    }
    return { points: new Float32Array(points), faces: new Uint32Array(faces) };
  }

  function disc(center, radius, up) {
    const other = Math.abs(up[0]) < 0.5 ? [1, 0, 0] : [0, 1, 0];
    const a = unit(crossed(up, other)), b = crossed(up, a), points = [...center], faces = [];
    for (let j = 0; j <= 96; j++) {
      const t = (2 * Math.PI * j) / 96, c = radius * Math.cos(t), s = radius * Math.sin(t);
      points.push(...[0, 1, 2].map((k) => center[k] + c * a[k] + s * b[k]));
      if (j < 96) faces.push(0, j + 1, j + 2);
    }
    return { points: new Float32Array(points), faces: new Uint32Array(faces) };
  }

  const packedMesh = (packed) => ({ points: numbers(packed.positions_mm), faces: Uint32Array.from(integers(packed.faces)) });
  const crossed = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((x) => x / Math.hypot(...a));

  const size = scene.size_mm, com = scene.com_mm, up = scene.pose[2];
  const things = [];
  if (scene.surface) things.push({
    name: scene.surface.name, mesh: { ...packedMesh(scene.surface), normals: numbers(scene.surface.normals) },
    color: [0.8, 0.8, 0.8, 1], tints: scene.surface.tints, swell: 0.003 * size, swatch: false,
  });
  for (const part of scene.parts) things.push({ name: part.name, mesh: packedMesh(part), color: [...part.color, 1] });
  const table = com.map((x, k) => x - scene.height_mm * up[k]);
  things.push({ name: scene.names.table, mesh: disc(table, 0.95 * size, up), color: [0.5, 0.53, 0.58, 0.3], whole: true });
  for (const share of [0.26, 0.18, 0.1]) things.push({
    shadow: true, mesh: disc(table, share * size, up), color: [0, 0, 0, 0.1], whole: true,
  });
  if (scene.zone) things.push({ name: scene.names.zone, mesh: packedMesh(scene.zone), color: [0.84, 0.37, 0.0, 0.3] });
  if (scene.margin_mm) things.push({
    name: scene.names.margin, mesh: sphere(com, scene.margin_mm), color: [0.0, 0.62, 0.45, 0.45], whole: true, above: true,
  });
  things.push({ name: scene.names.com, mesh: cross(com, 0.05 * size, 0.003 * size), color: [0.84, 0.1, 0.1, 1], whole: true, above: true });
  for (const thing of things) thing.shown ??= true;
  const ground = things.find((thing) => thing.name === scene.names.table);

  // ---- drawing

  let program, uniforms;
  function shader(kind, source) {
    const made = gl.createShader(kind);
    gl.shaderSource(made, source);
    gl.compileShader(made);
    gl.attachShader(program, made);
  }

  function attribute(name, data, type, normalized) {
    const place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, type, normalized, 0, 0);
  }

  function prepare() {
    program = gl.createProgram();
    shader(gl.VERTEX_SHADER, VERTEX);
    shader(gl.FRAGMENT_SHADER, FRAGMENT);
    gl.linkProgram(program);
    gl.useProgram(program);
    uniforms = Object.fromEntries(["projection", "view", "pose", "color", "tinted", "swell", "eye", "cut", "opened"]
      .map((name) => [name, gl.getUniformLocation(program, name)]));
    for (const thing of things) {
      const { points, faces, normals } = thing.mesh;
      thing.array = gl.createVertexArray();
      gl.bindVertexArray(thing.array);
      attribute("position", points, gl.FLOAT, false);
      attribute("normal", normals ?? normalsOf(points, faces), gl.FLOAT, false);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    }
    paint();
  }

  function paint() {
    const chosen = root.querySelector("input[name=coloring]:checked")?.value;
    for (const scale of root.querySelectorAll(".scale")) scale.hidden = scale.dataset.coloring !== chosen;
    for (const thing of things) if (thing.tints?.[chosen]) {
      gl.bindVertexArray(thing.array);
      attribute("tint", integers(thing.tints[chosen]), gl.UNSIGNED_BYTE, true);
      thing.tinted = true;
    }
    ask();
  }

  const START = { turn: -0.9, rise: 0.28, away: 2.5 };
  const VIEWS = {
    reset: START, front: { turn: -Math.PI / 2, rise: 0.05 }, side: { turn: 0, rise: 0.05 },
    above: { turn: -Math.PI / 2, rise: 1.5 }, below: { turn: -Math.PI / 2, rise: -1.2 },
  };
  const camera = { ...START };

  // Columns of 4 × 4 matrices, one after the other, as WebGL wants them.
  function lookAt(eye) {
    const z = unit(eye), x = unit(crossed([0, 0, 1], z)), y = crossed(z, x);
    return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, 0, 0, -Math.hypot(...eye), 1];
  }

  function perspective(aspect, away) {
    const f = 2.6 * Math.min(1, aspect), near = 0.05 * size, far = away + 3 * size;
    return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
  }

  let asked = false;
  function ask() {
    if (!asked) requestAnimationFrame(draw);
    asked = true;
  }

  function draw() {
    asked = false;
    if (gl.isContextLost()) return;
    const ratio = Math.min(2, devicePixelRatio || 1);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const { turn, rise } = camera, away = camera.away * size;
    const to = [Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise)];
    const eye = to.map((x) => away * x);
    const [p, q, r] = scene.pose, shift = scene.pose.map((row) => -row.reduce((sum, x, k) => sum + x * com[k], 0));
    gl.uniformMatrix4fv(uniforms.projection, false, perspective(canvas.width / canvas.height, away));
    gl.uniformMatrix4fv(uniforms.view, false, lookAt(eye));
    gl.uniformMatrix4fv(uniforms.pose, false, [p[0], q[0], r[0], 0, p[1], q[1], r[1], 0, p[2], q[2], r[2], 0, ...shift, 1]);
    gl.uniform3fv(uniforms.eye, eye);
    gl.uniform3fv(uniforms.cut, [Math.cos(turn), Math.sin(turn), 0]);
    const opened = document.getElementById("cut").checked;
    for (const thing of things) {
      if (!(thing.shadow ? ground : thing).shown || (thing.shadow && rise < 0)) continue;
      const clear = thing.color[3] < 1;
      gl.depthMask(!clear);
      gl[thing.above ? "disable" : "enable"](gl.DEPTH_TEST);
      gl.uniform1i(uniforms.opened, opened && !thing.whole ? 1 : 0);
      gl.uniform1i(uniforms.tinted, thing.tinted ? 1 : 0);
      gl.uniform1f(uniforms.swell, thing.swell ?? 0);
      gl.uniform4fv(uniforms.color, thing.color);
      gl.bindVertexArray(thing.array);
      gl.drawElements(gl.TRIANGLES, thing.mesh.faces.length, gl.UNSIGNED_INT, 0);
    }
    gl.depthMask(true);
  }

  // ---- handling

  function turnBy(dx, dy) {
    camera.turn -= dx;
    camera.rise = Math.max(-1.5, Math.min(1.5, camera.rise + dy));
    ask();
  }

  function zoomBy(factor) {
    camera.away = Math.max(1.1, Math.min(8, camera.away * factor));
    ask();
  }

  const fingers = new Map();
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (fingers.size === 1) turnBy(0.008 * (event.clientX - last.x), 0.008 * (event.clientY - last.y));
    else if (fingers.size === 2 && before > 0) zoomBy(before / Math.max(1, spread()));
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(Math.exp(0.0012 * Math.max(-200, Math.min(200, event.deltaY))));
  }, { passive: false });
  const KEYS = {
    ArrowLeft: () => turnBy(-0.09, 0), ArrowRight: () => turnBy(0.09, 0), ArrowUp: () => turnBy(0, 0.09),
    ArrowDown: () => turnBy(0, -0.09), "+": () => zoomBy(0.9), "=": () => zoomBy(0.9), "-": () => zoomBy(1.11),
    Home: () => { Object.assign(camera, START); ask(); },
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
    event.preventDefault();
    KEYS[event.key]();
  });
  for (const button of root.querySelectorAll("button[data-view]"))
    button.addEventListener("click", () => { Object.assign(camera, VIEWS[button.dataset.view]); ask(); });
  for (const input of root.querySelectorAll("input[name=coloring]")) input.addEventListener("change", paint);
  document.getElementById("cut").addEventListener("change", ask);

  const list = document.getElementById("shown");
  for (const thing of things) {
    if (thing.shadow) continue;
    const label = document.createElement("label"), box = document.createElement("input");
    const name = document.createElement("span"), swatch = document.createElement("i");
    box.type = "checkbox";
    box.checked = thing.shown;
    box.addEventListener("change", () => { thing.shown = box.checked; ask(); });
    name.textContent = thing.name;
    swatch.className = "swatch";
    swatch.style.background = `rgb(${thing.color.slice(0, 3).map((x) => Math.round(255 * x)).join(" ")})`;
    label.append(box, ...(thing.swatch === false ? [] : [swatch]), name);
    list.append(label);
  }

  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", prepare);
  root.hidden = false;
  document.getElementById("still").hidden = true;
  new ResizeObserver(ask).observe(canvas);
  prepare();
})();
