// Where the picture is seen from: dragging, wheel, fingers and keys turn, move and approach.
class ViewCamera {
  constructor(drawing) {
    this.drawing = drawing;
    this.canvas = drawing.canvas;
    const header = drawing.tissue.header;
    this.middle = header.low.map((low, axis) => low + header.extent[axis] / 2);
    this.size = Math.hypot(...header.extent) || 0.01;  // of a single node
    this.home();
    this.listen();
  }
  // From above the skin and the side of +y, or of +x for a cut of constant x, so that the cut is seen.
  home() {
    this.azimuth = this.side === 0 ? Math.PI / 2 - 0.45 : 0.45;
    this.elevation = 0.42;
    this.distance = 2.1 * this.size;
    this.target = this.middle.slice();
    if (this.drawing.tool) { this.target[2] -= 0.1 * this.size; }
    this.place();
  }
  place() {
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation));
    this.distance = Math.max(0.1 * this.size, Math.min(12 * this.size, this.distance));
    const flat = Math.cos(this.elevation) * this.distance;
    const camera = this.drawing.camera;
    camera.position.set(this.target[0] + flat * Math.sin(this.azimuth), this.target[1] + flat * Math.cos(this.azimuth),
                        this.target[2] - Math.sin(this.elevation) * this.distance);
    camera.near = Math.max(0.02 * this.size, this.distance - 1.5 * this.size);
    camera.far = this.distance + 4 * this.size;
    camera.updateProjectionMatrix();
    camera.lookAt(...this.target);
    camera.updateMatrixWorld();
  }
  turn(right, down) {
    this.azimuth -= right;
    this.elevation += down;
    this.redraw();
  }
  // By shares of the picture's height.
  pan(right, down) {
    const across = new THREE.Vector3().setFromMatrixColumn(this.drawing.camera.matrixWorld, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(this.drawing.camera.matrixWorld, 1);
    const reach = 0.5 * this.distance;
    across.multiplyScalar(-right * reach).addScaledVector(up, down * reach);
    this.target = this.target.map((x, c) => x + across.getComponent(c));
    this.redraw();
  }
  approach(factor) {
    this.distance *= factor;
    this.redraw();
  }
  redraw() {
    this.place();
    requestAnimationFrame(() => this.drawing.draw());
  }
  listen() {
    const fingers = new Map();
    const canvas = this.canvas;
    canvas.addEventListener('pointerdown', function (event) {
      fingers.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
    });
    ['pointerup', 'pointercancel'].forEach(function (name) {
      canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) { return; }
      const right = (event.clientX - before.clientX) / canvas.clientHeight;
      const down = (event.clientY - before.clientY) / canvas.clientHeight;
      if (fingers.size === 2) { this.pinch(fingers, event); }
      else if (event.shiftKey || event.buttons === 2) { this.pan(right, down); }
      else { this.turn(3 * right, 3 * down); }
      fingers.set(event.pointerId, event);
    });
    canvas.addEventListener('wheel', (event) => {
      if (document.activeElement !== canvas) { return; }  // the page scrolls until the picture was clicked
      event.preventDefault();
      this.approach(Math.exp(0.0012 * event.deltaY));
    }, { passive: false });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('keydown', (event) => this.key(event));
  }
  pinch(fingers, moved) {
    const [a, b] = Array.from(fingers.values());
    const still = a.pointerId === moved.pointerId ? b : a;
    const before = fingers.get(moved.pointerId);
    const gap = (one) => Math.hypot(one.clientX - still.clientX, one.clientY - still.clientY);
    this.approach(gap(before) / Math.max(1, gap(moved)));
  }
  key(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (way && event.shiftKey) { this.pan(0.05 * way[0], 0.05 * way[1]); }
    else if (way) { this.turn(0.1 * way[0], 0.1 * way[1]); }
    else if (event.key === '+' || event.key === '=') { this.approach(0.9); }
    else if (event.key === '-') { this.approach(1 / 0.9); }
    else if (event.key === '0') { this.home(); this.redraw(); }
    else { return; }
    event.preventDefault();
  }
}
