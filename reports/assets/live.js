// The page of a live run: frames come over a WebSocket, commands go back over it.
const seconds_shown = 10;
const pascals_per_mmhg = 133.322;
const gripStates = ['', 'opening', 'homing', 'force rises', 'ready', 'no reply', 'stopped', 'line closed'];

// Adds the changes of a frame: numbers of seven bits a byte with the sign in the lowest bit; a zero is followed by the
// number of further zeros (reports/live/frame_codec.hpp).
function addChanges(bytes, begin, values) {
  let at = begin, n = 0;
  const number = function () {
    let value = 0, scale = 1, byte;
    do { byte = bytes[at++]; value += (byte & 127) * scale; scale *= 128; } while (byte > 127);
    return value;
  };
  while (at < bytes.length) {
    const coded = number();
    if (coded === 0) { n += number() + 1; continue; }
    values[n++] += coded % 2 ? -(coded - 1) / 2 : coded / 2;
  }
  if (n !== values.length) { throw new Error('a frame has ' + n + ' of ' + values.length + ' values'); }
}

// Values over the last seconds, drawn as lines.
class Curves {
  constructor(canvas, colours) {
    this.canvas = canvas;
    this.colours = colours;
    this.clear();
  }
  clear() { this.rows = []; }
  add(time, values) {
    const last = this.rows[this.rows.length - 1];
    if (last && time <= last[0]) { return; }
    this.rows.push([time].concat(values));
    while (this.rows[0][0] < time - seconds_shown) { this.rows.shift(); }
  }
  draw() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) { return; }
    if (this.canvas.width !== Math.round(width * ratio)) { this.canvas.width = Math.round(width * ratio); }
    if (this.canvas.height !== Math.round(height * ratio)) { this.canvas.height = Math.round(height * ratio); }
    const pen = this.canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    let low = 0, high = 1e-3;
    this.rows.forEach((row) => row.slice(1).forEach(function (value) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }));
    const step = Math.pow(10, Math.floor(Math.log10((high - low) / 2)));
    const spread = [1, 2, 5, 10].map((n) => n * step).find((size) => (high - low) / size <= 4) || 10 * step;
    const end = this.rows.length ? this.rows[this.rows.length - 1][0] : seconds_shown;
    const x = (time) => 44 + (width - 52) * (1 + (time - Math.max(end, seconds_shown)) / seconds_shown);
    const y = (value) => height - 10 - (height - 20) * (value - low) / (high - low);
    pen.font = '11px system-ui, sans-serif';
    pen.textAlign = 'right';
    pen.lineWidth = 1;
    for (let value = Math.ceil(low / spread) * spread; value <= high; value += spread) {
      pen.strokeStyle = colour('--grid');
      pen.beginPath(); pen.moveTo(44, y(value)); pen.lineTo(width - 8, y(value)); pen.stroke();
      pen.fillStyle = colour('--soft');
      pen.fillText(String(+value.toPrecision(3)).replace('-', '−'), 38, y(value) + 4);
    }
    pen.lineWidth = 1.6;
    this.colours.forEach((name, n) => {
      pen.strokeStyle = colour(name);
      pen.beginPath();
      this.rows.forEach((row, r) => { r ? pen.lineTo(x(row[0]), y(row[n + 1])) : pen.moveTo(x(row[0]), y(row[n + 1])); });
      pen.stroke();
    });
  }
}

class Live {
  constructor(about, drawing, controls) {
    this.about = about;
    this.drawing = drawing;
    this.controls = controls;
    this.find = (name) => document.getElementById('live-' + name);
    this.root = document.getElementById('live');
    this.moved = new Int16Array(3 * about.nodes);
    this.frames = 0;
    this.state = null;
    this.force = new Curves(this.find('force'), ['--series-0', '--series-1']);
    this.pressure = new Curves(this.find('pressure'), ['--series-2']);
    this.root.classList.toggle('with-tool', about.tool);
    this.find('title').textContent = about.title;
    this.find('pressure-figure').hidden = !about.pressure;
    drawing.tissue.header.step = about.step;
    drawing.tissue.header.displacement = 100 * about.step;
    if (about.tool) { this.makeArrow(); }
    this.listen();
    this.connect();
  }
  // The force of the tissue on the tool, beside its tip and along its line; seen through the tissue.
  makeArrow() {
    const header = this.drawing.tissue.header;
    const material = new THREE.MeshBasicMaterial({ color: 0xd55e00, depthTest: false, transparent: true,
                                                   side: THREE.DoubleSide });
    const size = this.size = Math.hypot(...header.extent) || 0.01;
    const part = (geometry, moved) => {
      const mesh = new THREE.Mesh(geometry.translate(0, moved, 0), material);
      mesh.renderOrder = 1000;
      return mesh;
    };
    this.shaft = part(new THREE.CylinderBufferGeometry(0.006 * size, 0.006 * size, 1, 16), 0.5);
    this.head = part(new THREE.ConeBufferGeometry(0.016 * size, 0.04 * size, 20), 0.02 * size);
    this.arrow = new THREE.Group();
    this.arrow.add(this.shaft, this.head);
    const outwards = new THREE.Vector3(...header.tool.direction).negate();
    this.arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), outwards);
    this.drawing.scene.add(this.arrow);
  }
  moveArrow(state) {
    const tool = this.drawing.tissue.header.tool;
    const length = Math.min(0.5, 0.04 * Math.abs(state.reaction)) * this.size;
    this.arrow.visible = length > 0.002 * this.size;
    const tip = tool.origin.map((x, c) => x + state.place * tool.direction[c]);
    this.arrow.position.set(tip[0] + 0.05 * this.size, tip[1], tip[2]);
    this.arrow.scale.y = state.reaction < 0 ? -1 : 1;  // tissue that holds the shaft back points inwards
    this.shaft.scale.y = Math.max(length, 1e-6);
    this.head.position.y = length;
  }
  // ---- the line ----
  connect() {
    this.socket = new WebSocket('ws://' + location.host + '/socket' + location.search);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = (event) => this.take(new Uint8Array(event.data));
    this.socket.onclose = () => {
      this.find('link').textContent = 'no connection: the program ended, or its address is an old one';
      this.root.dataset.state = 'closed';
      setTimeout(() => this.connect(), 2000);
    };
  }
  send(what, value, index) {
    if (this.socket.readyState !== WebSocket.OPEN) { return; }
    this.socket.send(JSON.stringify({ do: what, value: value, index: index }));
  }
  take(bytes) {
    const size = bytes[4] | bytes[5] << 8 | bytes[6] << 16 | bytes[7] << 24;
    const state = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + size)));
    if (bytes[1]) { this.moved.fill(0); }
    addChanges(bytes, 8 + size, this.moved);
    ++this.frames;
    this.root.dataset.frames = this.frames;
    this.root.dataset.state = 'open';
    if (this.state && state.run !== this.state.run) { this.force.clear(); this.pressure.clear(); this.target = undefined; }
    this.state = state;
    this.force.add(state.time, [state.applied, state.reaction]);
    this.pressure.add(state.time, [state.pressure / pascals_per_mmhg]);
    if (!this.waiting) {
      this.waiting = true;
      requestAnimationFrame(() => { this.waiting = false; this.draw(); });
    }
  }
  // ---- what is seen ----
  draw() {
    const state = this.state;
    const header = this.drawing.tissue.header;
    this.drawing.tissue.frames = [{ moved: this.moved, line: new Int8Array(this.moved.length) }];
    header.frames = [{ time: state.time, place: state.place, depth: state.depth, applied: state.applied,
                       reaction: state.reaction, layer: state.layer, event: '' }];
    let most = header.displacement / header.step;
    this.moved.forEach(function (value) { most = Math.max(most, Math.abs(value)); });
    header.displacement = most * header.step;
    if (this.arrow) { this.moveArrow(state); }
    this.controls.set({ frame: 0 });
    this.force.draw();
    if (this.about.pressure) { this.pressure.draw(); }
    this.say();
  }
  say() {
    const state = this.state;
    const count = (number) => number.toLocaleString('en');
    const rows = [['time', secondsInWords(state.time)]];
    if (this.about.tool) {
      rows.push(['applied', inWords(state.applied, 'N'), 'applied'], ['reaction', inWords(state.reaction, 'N'), 'reaction'],
                ['depth', inWords(state.depth, 'm'), 'depth'], ['layer', state.layer || 'outside', 'layer']);
    }
    if (this.about.pressure) { rows.push(['pressure', (state.pressure / pascals_per_mmhg).toFixed(1) + '\u00a0mmHg']); }
    if (state.device) { rows.push(['device', gripStates[state.device]], ['force sent', inWords(state.device_force, 'N')]); }
    rows.push(['ticks', count(state.ticks)], ['missed', count(state.missed), 'missed'], ['worst tick', inWords(state.worst, 's'), 'worst'],
              ['dropped', count(state.dropped), 'dropped'], ['torn', count(state.torn)], ['viewers', count(state.viewers)]);
    if (state.lost_rows) { rows.push(['rows not recorded', count(state.lost_rows)]); }
    const numbers = this.find('numbers');
    if (numbers.children.length !== 2 * rows.length) {
      numbers.replaceChildren();
      rows.forEach(() => numbers.append(document.createElement('dt'), document.createElement('dd')));
    }
    rows.forEach(function (row, n) {
      const [name, value] = [numbers.children[2 * n], numbers.children[2 * n + 1]];
      if (name.textContent !== row[0]) { name.textContent = row[0]; }
      if (value.textContent !== row[1]) { value.textContent = row[1]; }
      if (row[2]) { value.id = 'live-says-' + row[2]; }
    });
    const events = state.events.slice(-6).join('\n');
    if (events !== this.events) {
      this.events = events;
      this.find('events').replaceChildren(...state.events.slice(-6).map(function (words) {
        return Object.assign(document.createElement('li'), { textContent: words });
      }));
    }
    this.find('link').textContent = state.writer === 'another' ? 'another page operates; this one watches'
      : state.writer === 'you' ? 'this page operates' : 'the first page that gives a command operates';
    this.find('start').textContent = state.running && !state.ended ? 'Pause' : 'Start';
    this.find('start').disabled = state.ended > 0;
    const warning = state.ended === 2 ? 'The simulation diverged. Reset loads the scene again.'
      : state.ended === 1 ? 'The longest run is over. Reset begins again.' : '';
    this.find('warning').hidden = !warning;
    this.find('warning').textContent = warning;
    if (this.about.tool) { this.sayGrip(state); }
    this.sayHoming(state.device);
  }
  sayGrip(state) {
    const grip = this.find('grip');
    this.find('grip-says').textContent = 'at ' + inWords(state.grip, 'm') + ', tool at ' + inWords(state.place, 'm');
    grip.setAttribute('aria-valuenow', (1e3 * state.grip).toFixed(1));
    grip.setAttribute('aria-valuetext', inWords(state.grip, 'm'));
    if (document.activeElement !== this.find('speed')) { this.find('speed').value = 1e3 * state.speed; }
    this.find('speed-says').textContent = inWords(state.speed, 'm/s');
  }
  sayHoming(device) {
    this.find('homing').hidden = !(device >= 1 && device <= 3);
    [['open', 1], ['home', 2], ['ramp', 3]].forEach(([name, step]) => {
      this.find('step-' + name).className = device === step ? 'now' : device > step ? 'past' : '';
    });
  }
  // ---- what a person does ----
  listen() {
    const click = (name, act) => this.find(name).addEventListener('click', act);
    click('start', () => this.send(this.state && this.state.running ? 'pause' : 'start'));
    click('reset', () => this.send('reset'));
    click('in', () => { this.target = undefined; this.send('drive', this.about.depth); });
    click('out', () => { this.target = undefined; this.send('drive', Math.min(this.about.from, -0.005)); });
    click('stop', () => this.send('stop'));
    this.find('speed').addEventListener('input', (event) => this.send('speed', 1e-3 * Number(event.target.value)));
    document.addEventListener('keydown', (event) => { if (event.key === 'Escape') { this.send('stop'); } });
    this.find('materials').hidden = this.about.materials.length === 0;
    this.about.materials.forEach((name, n) => {
      const label = document.createElement('label');
      const slider = Object.assign(document.createElement('input'), { type: 'range', min: -1, max: 1, step: 0.02, value: 0 });
      const says = Object.assign(document.createElement('output'), { textContent: '× 1' });
      slider.addEventListener('input', () => {
        const factor = Math.pow(5, Number(slider.value));
        says.textContent = '× ' + factor.toPrecision(3);
        this.send('stiffness', factor, n);
      });
      label.append(name, slider, says);
      this.find('sliders').append(label);
    });
    this.holdGrip();
    this.holdTool();
  }
  // Moves the target of the grip [m].
  move(by) {
    if (!this.state) { return; }
    const from = this.target === undefined ? this.state.grip : this.target;
    const low = Math.min(this.about.from, 0) - 0.02;
    this.target = Math.max(low, Math.min(1.5 * this.about.depth + 0.01, from + by));
    this.send('hold', this.target);
  }
  // Pixels of the pad are a quarter of a millimetre; arrow keys move by half a millimetre.
  holdGrip() {
    const grip = this.find('grip');
    let last = null;
    grip.addEventListener('pointerdown', (event) => {
      grip.setPointerCapture(event.pointerId);
      grip.classList.add('held');
      last = event.clientY;
    });
    grip.addEventListener('pointermove', (event) => {
      if (last === null) { return; }
      this.move(2.5e-4 * (event.clientY - last));
      last = event.clientY;
    });
    ['pointerup', 'pointercancel'].forEach((name) => grip.addEventListener(name, () => {
      last = null;
      grip.classList.remove('held');
    }));
    grip.addEventListener('keydown', (event) => {
      const way = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1, PageDown: 10, PageUp: -10 }[event.key];
      if (!way) { return; }
      this.move(5e-4 * way);
      event.preventDefault();
    });
  }
  // A drag that begins at the tool in the picture moves it along its line; any other turns the view.
  holdTool() {
    if (!this.about.tool) { return; }
    const canvas = this.drawing.canvas;
    const tool = this.drawing.tissue.header.tool;
    let held = null;
    const seen = (place) => {
      const at = new THREE.Vector3(...tool.origin.map((x, c) => x + place * tool.direction[c])).project(this.drawing.camera);
      const box = canvas.getBoundingClientRect();
      return [box.left + (1 + at.x) * box.width / 2, box.top + (1 - at.y) * box.height / 2];
    };
    canvas.addEventListener('pointerdown', (event) => {
      if (!this.state) { return; }
      const length = 0.09;
      const tip = seen(this.state.place), end = seen(this.state.place - length);
      const way = [tip[0] - end[0], tip[1] - end[1]];
      const size = Math.hypot(...way) || 1;
      const from = [event.clientX - end[0], event.clientY - end[1]];
      const along = (from[0] * way[0] + from[1] * way[1]) / size;
      const beside = Math.abs(from[0] * way[1] - from[1] * way[0]) / size;
      if (beside > 16 || along < -20 || along > size + 10) { return; }
      held = { x: event.clientX, y: event.clientY, way: way.map((c) => c / size), scale: length / size };
      canvas.setPointerCapture(event.pointerId);
      event.stopImmediatePropagation();
    }, true);
    canvas.addEventListener('pointermove', (event) => {
      if (!held) { return; }
      this.move(held.scale * ((event.clientX - held.x) * held.way[0] + (event.clientY - held.y) * held.way[1]));
      held.x = event.clientX;
      held.y = event.clientY;
      event.stopImmediatePropagation();
    }, true);
    ['pointerup', 'pointercancel'].forEach((name) => canvas.addEventListener(name, () => { held = null; }, true));
  }
}

async function startLive() {
  const why = document.getElementById('view-why');
  try {
    const text = (id) => document.getElementById(id).textContent;
    const about = JSON.parse(text('live-about'));
    const tissue = new Tissue(JSON.parse(text('view-header')), await inflate(text('view-numbers')));
    const canvas = document.getElementById('view-canvas');
    if (!document.createElement('canvas').getContext('webgl')) { throw new Error('this browser offers no WebGL'); }
    document.getElementById('view-body').hidden = false;
    document.querySelector('#view-colour option[value="force"]').remove();
    const drawing = new Drawing(canvas, tissue);
    const controls = new Controls(drawing, new ViewCamera(drawing));
    document.getElementById('view-show-lines').parentElement.remove();
    document.getElementById('view-help').textContent = 'Drag the tool along its line to hold it; drag elsewhere to turn, with shift to move; ' +
      'use the wheel once the picture was clicked. The arrow shows the force of the tissue on the tool.';
    why.hidden = true;
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', function () {
      drawing.followTheme();
      controls.set({});
    });
    new ResizeObserver(() => requestAnimationFrame(() => drawing.draw())).observe(canvas);
    new Live(about, drawing, controls);
  } catch (problem) {
    why.textContent = 'No live view: ' + problem.message + '.';
    document.getElementById('live').dataset.state = 'failed';
  }
}
startLive();
