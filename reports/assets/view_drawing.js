// The picture: everything that three.js draws, from a tissue and what a person wants to see of it.
class Drawing {
  constructor(canvas, tissue) {
    this.canvas = canvas;
    this.tissue = tissue;
    this.renderer = new THREE.WebGLRenderer({ canvas: canvas, antialias: true, alpha: true });
    this.renderer.localClippingEnabled = true;
    this.plane = new THREE.Plane();
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(28, 4 / 3, 0.001, 50);
    this.camera.up.set(0, 0, -1);
    const lamp = new THREE.DirectionalLight(0xffffff, 0.75);
    lamp.position.set(0.25, 0.55, 0.8);
    this.camera.add(lamp);
    this.scene.add(this.camera, new THREE.AmbientLight(0xffffff, 0.5));
    this.position = new Float32Array(3 * tissue.count);
    this.share = new Float32Array(tissue.count);
    this.makeUniforms();
    this.makeNodes();
    this.makeSprings();
    this.makeLines();
    this.makeSides();
    this.makeSurfaces();
    this.followTheme();
    if (tissue.header.tool) {
      this.tool = toolBody(tissue.header.tool);
      this.scene.add(this.tool);
    }
  }
  makeUniforms() {
    const colours = this.tissue.header.colours;
    const texture = function (list, count) {
      const data = new Uint8Array(3 * count);
      list.forEach(function (colour, n) {
        new THREE.Color(colour).toArray().forEach((part, c) => { data[3 * n + c] = Math.round(255 * part); });
      });
      const made = new THREE.DataTexture(data, count, 1, THREE.RGBFormat);
      made.unpackAlignment = 1;
      made.needsUpdate = true;
      return made;
    };
    const scale = [];
    for (let n = 0; n < 256; ++n) {
      const along = n / 255 * (colours.scale.length - 1);
      const below = Math.min(Math.floor(along), colours.scale.length - 2);
      scale.push(new THREE.Color(colours.scale[below]).lerp(new THREE.Color(colours.scale[below + 1]), along - below));
    }
    const smooth = texture(scale, 256);
    smooth.minFilter = smooth.magFilter = THREE.LinearFilter;
    this.uniforms = {
      opacity: { value: new Float32Array(32).fill(1) }, cut: { value: new THREE.Vector4(0, 0, 0, 1) },
      scale: { value: smooth }, tissueColours: { value: texture(colours.tissue, 32) },
      scaled: { value: 1 }, own: { value: -1 }
    };
  }
  material(shaders, own, options) {
    return new THREE.ShaderMaterial(Object.assign({
      vertexShader: shaders.vertex, fragmentShader: shaders.fragment,
      uniforms: Object.assign({}, this.uniforms, own), transparent: true, extensions: { derivatives: true }
    }, options));
  }
  // Geometry whose vertices are the nodes themselves.
  makeNodes() {
    const tissue = this.tissue;
    this.attributes = {
      position: new THREE.BufferAttribute(this.position, 3),
      share: new THREE.BufferAttribute(this.share, 1),
      rest: new THREE.BufferAttribute(tissue.rest, 3),
      label: new THREE.BufferAttribute(Float32Array.from(tissue.label), 1)
    };
    this.nodeSize = { value: 1 };
    this.nodes = new THREE.Points(this.nodeGeometry(), this.material(nodeShaders, { size: this.nodeSize }));
    this.add(this.nodes);
  }
  nodeGeometry(index) {
    const geometry = new THREE.BufferGeometry();
    Object.keys(this.attributes).forEach((name) => geometry.setAttribute(name, this.attributes[name]));
    if (index) { geometry.setIndex(index); }
    return geometry;
  }
  add(object) {
    object.frustumCulled = false;  // its places change
    this.scene.add(object);
  }
  // Geometry of strokes: its vertex n belongs to the node nodeOf[n].
  strokeGeometry(nodeOf) {
    const tissue = this.tissue;
    const geometry = new THREE.BufferGeometry();
    const make = function (name, size) {
      const attribute = new THREE.BufferAttribute(new Float32Array(size * nodeOf.length), size);
      geometry.setAttribute(name, attribute);
      return attribute.array;
    };
    make('position', 3);
    make('share', 1);
    const rest = make('rest', 3), label = make('label', 1);
    nodeOf.forEach(function (node, n) {
      for (let c = 0; c < 3; ++c) { rest[3 * n + c] = tissue.rest[3 * node + c]; }
      label[n] = tissue.label[node];
    });
    return geometry;
  }
  // Two vertices a spring, so that each can have its own stiffness.
  makeSprings() {
    const springs = this.tissue.springs;
    const ends = this.springEnds = new Uint32Array(2 * springs.a.length);
    springs.a.forEach(function (a, s) { ends[2 * s] = a; ends[2 * s + 1] = a + springs.way[s]; });
    this.springInk = { value: new THREE.Vector4() };
    const paint = { ink: this.springInk, nearer: { value: 0 } };
    const material = this.material(lineShaders, paint, { transparent: false });
    this.springs = new THREE.LineSegments(this.strokeGeometry(ends), material);
    this.add(this.springs);
  }
  // Force lines: one stroke through each node, pulls and pushes in two colours.
  makeLines() {
    this.lineColours = { pull: { value: new THREE.Color() }, push: { value: new THREE.Color() } };
    const nodeOf = Uint32Array.from({ length: 2 * this.tissue.count }, (_, n) => n >> 1);
    const paint = Object.assign({ nearer: { value: 2e-3 } }, this.lineColours);
    const material = this.material(strokeShaders, paint, { transparent: false });
    this.lines = new THREE.LineSegments(this.strokeGeometry(nodeOf), material);
    this.add(this.lines);
  }
  // The body of each kind of tissue, its back drawn before its front so that it can be seen through.
  makeSides() {
    this.sides = [];
    if (!this.tissue.header.grid) { return; }
    const depth = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.tissue.header.labels.forEach((label, n) => {
      const geometry = this.nodeGeometry([]);
      const pair = [THREE.BackSide, THREE.FrontSide].map((side) => {
        const material = this.material(sideShaders, { own: { value: n } }, Object.assign({ side: side }, depth));
        const mesh = new THREE.Mesh(geometry, material);
        this.add(mesh);
        return mesh;
      });
      this.sides.push({ geometry: geometry, meshes: pair, label: n });
    });
    const paint = { ink: { value: new THREE.Vector4(0, 0, 0, 0.35) }, nearer: { value: 2e-4 },
                    cut: { value: new THREE.Vector4(0, 0, 0, 1) } };  // the cells behind the cut have all their edges
    const material = this.material(lineShaders, paint, { transparent: false });
    this.edges = new THREE.LineSegments(this.nodeGeometry([]), material);
    this.add(this.edges);
  }
  makeSurfaces() {
    this.surfaces = this.tissue.surfaces.map((about) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * about.counts.length), 3));
      geometry.setIndex(Array.from(about.corners));
      const material = new THREE.MeshPhongMaterial({
        color: 0xe0ac90, specular: 0x2a1f1a, shininess: 18, side: THREE.DoubleSide, transparent: true,
        polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2, clippingPlanes: [this.plane]
      });
      const mesh = new THREE.Mesh(geometry, material);
      this.add(mesh);
      return { about: about, mesh: mesh };
    });
  }
  // Lines take colours of the page, so that they are seen on light and on dark paper.
  followTheme() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => new THREE.Color(style.getPropertyValue(name).trim());
    this.springInk.value.set(...colour('--soft').toArray(), 0.25);
    this.lineColours.pull.value.copy(colour('--series-1'));
    this.lineColours.push.value.copy(colour('--series-0'));
  }
  // ---- what a person chose ----
  show(state) {
    this.state = state;
    this.uniforms.opacity.value.set(state.opacity);
    this.uniforms.scaled.value = state.colour === 'tissue' ? 0 : 1;
    const key = state.axis + ' ' + state.cut;
    if (key !== this.cutKey) { this.cutAt(state); this.cutKey = key; }
    this.nodes.visible = state.nodes;
    this.springs.visible = state.springs;
    this.lines.visible = state.lines;
    if (this.edges) { this.edges.visible = state.body; }
    if (this.tool) { this.tool.visible = state.tool; }
    this.sides.forEach(function (part) {
      const opacity = state.opacity[part.label];
      part.meshes.forEach(function (mesh) {
        mesh.visible = state.body && opacity > 0.01;
        mesh.material.depthWrite = opacity > 0.99;
      });
    });
    this.surfaces.forEach(function (surface) {
      surface.mesh.visible = state.skin > 0.01;
      surface.mesh.material.opacity = state.skin;
      surface.mesh.material.depthWrite = state.skin > 0.99;
    });
    this.move(state);
  }
  cutAt(state) {
    const axis = state.axis;
    const nothing = axis < 0;
    const normal = [0, 1, 2].map((c) => c === axis ? 1 : 0);
    const at = nothing ? 1 : state.cut + 1e-6;  // nodes in the plane are seen
    this.uniforms.cut.value.set(...normal, at);
    this.plane.normal.set(...normal).negate();
    this.plane.constant = at;
    if (!this.sides.length) { return; }
    const rest = this.tissue.rest;
    const found = sidesOfCells(this.tissue, function (corners) {
      return nothing || rest[3 * corners[7] + axis] <= at;  // no cell lies before the plane, and none hides the tool
    });
    this.sides.forEach(function (part) {
      part.geometry.setIndex(found.triangles[part.label]);
    });
    this.edges.geometry.setIndex(found.edges);
  }
  move(state) {
    const tissue = this.tissue;
    tissue.positions(state.frame, state.enlarged, this.position);
    if (state.colour !== 'tissue') { tissue.shares(state.frame, state.colour, this.share); }
    this.attributes.position.needsUpdate = this.attributes.share.needsUpdate = true;
    if (state.springs) { this.moveSprings(state); }
    if (state.lines) { this.moveLines(state); }
    this.surfaces.forEach((surface) => this.moveSurface(surface));
    if (this.tool) {
      const about = tissue.header.tool;
      const place = tissue.header.frames[state.frame].place;
      this.tool.position.set(...about.origin.map((x, c) => x + place * about.direction[c]));
    }
    this.draw();
  }
  moveSprings(state) {
    const { position, share } = this.springs.geometry.attributes;
    const own = state.colour === 'stiffness' ? this.tissue.springs.stiffness : null;
    const from = this.position;
    const into = position.array;
    this.springEnds.forEach((node, n) => {
      into[3 * n] = from[3 * node]; into[3 * n + 1] = from[3 * node + 1]; into[3 * n + 2] = from[3 * node + 2];
      share.array[n] = own ? own[n >> 1] / 255 : this.share[node];
    });
    position.needsUpdate = share.needsUpdate = true;
  }
  moveLines(state) {
    const { position, share } = this.lines.geometry.attributes;
    const line = this.tissue.frames[state.frame].line;
    const half = 0.75 * this.tissue.spacing() / 127;
    for (let n = 0; n < this.tissue.count; ++n) {
      const [x, y, z] = [line[3 * n], line[3 * n + 1], line[3 * n + 2]];
      const first = z || y || x;
      for (let c = 0; c < 3; ++c) {
        position.array[6 * n + c] = this.position[3 * n + c] - half * line[3 * n + c];
        position.array[6 * n + 3 + c] = this.position[3 * n + c] + half * line[3 * n + c];
      }
      share.array[2 * n] = share.array[2 * n + 1] = Math.hypot(x, y, z) < 3 ? 0 : first > 0 ? 1 : -1;
    }
    position.needsUpdate = share.needsUpdate = true;
  }
  moveSurface(surface) {
    const { rest, counts, nodes, weights } = surface.about;
    const position = surface.mesh.geometry.attributes.position;
    let next = 0;
    counts.forEach((count, vertex) => {
      const sum = [rest[3 * vertex], rest[3 * vertex + 1], rest[3 * vertex + 2]];
      for (const end = next + count; next < end; ++next) {
        const node = 3 * nodes[next];
        for (let c = 0; c < 3; ++c) {
          sum[c] += weights[next] / 32767 * (this.position[node + c] - this.tissue.rest[node + c]);
        }
      }
      position.setXYZ(vertex, sum[0], sum[1], sum[2]);
    });
    position.needsUpdate = true;
    surface.mesh.geometry.computeVertexNormals();
  }
  draw() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) { return; }
    if (this.canvas.width !== Math.floor(width * ratio) || this.canvas.height !== Math.floor(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    const zoom = height * ratio / (2 * Math.tan(this.camera.fov * Math.PI / 360));
    this.nodeSize.value = 0.24 * this.tissue.spacing() * zoom;
    this.orderSides();
    this.renderer.render(this.scene, this.camera);
  }
  // What can be seen through is drawn from far to near.
  orderSides() {
    const centre = new THREE.Vector3(), corner = new THREE.Vector3();
    const far = this.sides.map((part) => {
      const index = part.geometry.index;
      centre.set(0, 0, 0);
      if (!index || !index.count) { return 0; }
      for (let n = 0; n < index.count; n += 3) { centre.add(corner.fromArray(this.position, 3 * index.array[n])); }
      return centre.multiplyScalar(3 / index.count).distanceTo(this.camera.position);
    });
    const order = far.map((_, n) => n).sort(function (a, b) { return far[b] - far[a]; });
    order.forEach((part, place) => {
      this.sides[part].meshes.forEach(function (mesh, side) { mesh.renderOrder = 2 * place + side; });
    });
    this.surfaces.forEach(function (surface) { surface.mesh.renderOrder = 2 * order.length + 2; });
  }
}
