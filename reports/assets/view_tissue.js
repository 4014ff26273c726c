// The tissue of the page: nodes, springs, surfaces, and where they are at every instant.
class Tissue {
  constructor(header, bytes) {
    this.header = header;
    this.count = header.nodes;
    const reader = new ByteReader(bytes);
    this.readNodes(reader);
    this.springs = { a: reader.differences(header.springs, 32), way: reader.differences(header.springs, 32),
                     stiffness: reader.plane(header.springs) };
    this.surfaces = header.surfaces.map(function (about) {
      const rest = new Float32Array(3 * about.vertices);
      for (let axis = 0; axis < 3; ++axis) { reader.places(about, about.vertices, axis, rest); }
      return { label: about.label, rest: rest, counts: reader.plane(about.vertices), nodes: reader.differences(about.supports, 32),
               weights: reader.differences(about.supports, 16), corners: reader.differences(3 * about.triangles, 32) };
    });
    let before = new Int16Array(3 * this.count);
    this.frames = header.frames.map(() => {
      before = reader.changes(before);
      const line = reader.plane(3 * this.count);
      return { moved: before, line: new Int8Array(line.buffer, line.byteOffset, line.length) };
    });
  }
  readNodes(reader) {
    const header = this.header;
    this.rest = new Float32Array(3 * this.count);
    for (let axis = 0; axis < 3; ++axis) { reader.places(header, this.count, axis, this.rest); }
    this.label = reader.plane(this.count);
    this.fixed = reader.plane(this.count);
    this.stiffness = reader.plane(this.count);
    if (!header.grid) { return; }
    this.cell = reader.plane(this.count);
    this.grid = [0, 1, 2].map(() => reader.differences(this.count, 16));
  }
  // Places of all nodes [m], their movement times `enlarged`.
  positions(frame, enlarged, into) {
    const moved = this.frames[frame].moved;
    const scale = this.header.step * enlarged;
    for (let n = 0; n < into.length; ++n) { into[n] = this.rest[n] + scale * moved[n]; }
  }
  // What nodes are coloured by, from 0 to 1.
  shares(frame, quantity, into) {
    if (quantity === 'stiffness') {
      for (let n = 0; n < this.count; ++n) { into[n] = this.stiffness[n] / 255; }
      return;
    }
    const force = quantity === 'force';
    const values = force ? this.frames[frame].line : this.frames[frame].moved;
    const full = force ? 127 : Math.max(this.header.displacement / (this.header.step || 1), 1e-30);
    for (let n = 0; n < this.count; ++n) {
      into[n] = Math.hypot(values[3 * n], values[3 * n + 1], values[3 * n + 2]) / full;
    }
  }
  // Smallest distance between neighbours, about, to size what is drawn.
  spacing() {
    const extent = this.header.extent;
    const room = extent.reduce(function (product, length) { return product * Math.max(length, 1e-6); }, 1);
    return Math.min(Math.cbrt(room / this.count), Math.max(...extent) / 6);
  }
}

// For a node of a grid and a step along it, the node there; undefined: none.
function neighbours(tissue) {
  const [gx, gy, gz] = tissue.grid;
  const width = 2 + gx.reduce((most, at) => Math.max(most, at), 0);
  const depth = 2 + gy.reduce((most, at) => Math.max(most, at), 0);
  const slot = function (x, y, z) { return (z * depth + y) * width + x; };
  const nodeAt = new Map();
  for (let n = 0; n < tissue.count; ++n) {
    if (gx[n] < 65535) { nodeAt.set(slot(gx[n], gy[n], gz[n]), n); }
  }
  return function (n, x, y, z) { return nodeAt.get(slot(gx[n] + x, gy[n] + y, gz[n] + z)); };
}

// Sides of the cells of one piece of a grid, those cells whose corners `keeps` holds: triangles of each kind of
// tissue, and the edges of what lies open.
function sidesOfCells(tissue, keeps) {
  const sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
  const steps = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
  const beside = neighbours(tissue);
  const kept = new Map();  // lowest corner -> corners
  for (let n = 0; n < tissue.count; ++n) {
    if (!tissue.cell[n]) { continue; }
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((c) => beside(n, c & 1, c >> 1 & 1, c >> 2));
    if (keeps(corners)) { kept.set(n, corners); }
  }
  const triangles = tissue.header.labels.map(() => []);
  const edges = new Map();
  kept.forEach(function (corners, n) {
    sides.forEach(function (side, towards) {
      const next = beside(n, ...steps[towards]);
      const inside = next !== undefined && kept.has(next);
      if (inside && tissue.label[next] === tissue.label[n]) { return; }
      const [a, b, c, d] = side.map((corner) => corners[corner]);
      triangles[tissue.label[n]].push(a, b, c, a, c, d);
      if (inside) { return; }
      [[a, b], [b, c], [c, d], [d, a]].forEach(function (pair) {
        edges.set(Math.min(...pair) * tissue.count + Math.max(...pair), pair);
      });
    });
  });
  const open = [];
  edges.forEach((pair) => open.push(pair[0], pair[1]));
  return { triangles: triangles, edges: open };
}
