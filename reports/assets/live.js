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
    if (about.tool) { this.makeForces(); }
    this.listen();
    this.connect();
  }
  // Force lines beside the tip, along the tool: what the hand gives on one side, the parts of the tissue's force on the
  // other, all on one scale. They are seen through the tissue.
  makeForces() {
    this.size = Math.hypot(...this.drawing.tissue.header.extent) || 0.01;
    const inwards = new THREE.Vector3(...this.drawing.tissue.header.tool.direction);
    const needle = this.about.needle;
    this.lines = [['hand', 'applied', 0, -1], [needle ? 'tip, cutting' : '', 'cutting', 1, 1],
                  [needle ? 'tip, pressing' : 'tissue', 'pressing', needle ? 3 : 1, 1], [needle ? 'friction of the shaft' : '', 'friction', 2, 1]]
      .filter((each) => each[0]).map(([label, key, series, side], n) => {
        const material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true, side: THREE.DoubleSide });
        const part = (geometry, moved) => {
          const mesh = new THREE.Mesh(geometry.translate(0, moved, 0), material);
          mesh.renderOrder = 1000;
          return mesh;
        };
        const line = { label: label, key: key, series: '--series-' + series, material: material, group: new THREE.Group(),
                       shaft: part(new THREE.CylinderBufferGeometry(0.0045 * this.size, 0.0045 * this.size, 1, 12), 0.5),
                       head: part(new THREE.ConeBufferGeometry(0.012 * this.size, 0.03 * this.size, 16), 0.015 * this.size),
                       aside: (side < 0 ? -0.05 : 0.022 + 0.028 * n) * this.size, inwards: side < 0 };
        line.group.add(line.shaft, line.head);
        line.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), inwards.clone().multiplyScalar(side < 0 ? 1 : -1));
        this.drawing.scene.add(line.group);
        const row = document.createElement('li');
        row.append(document.createElement('i'), label, line.says = document.createElement('output'));
        row.firstChild.style.background = 'var(' + line.series + ')';
        this.find('lines').append(row);
        return line;
      });
    this.drawing.canvas.parentElement.append(this.find('lines'));
    this.find('lines').hidden = false;
    this.perNewton = 0;
    this.colourForces();
  }
  colourForces() {
    const style = getComputedStyle(document.documentElement);
    (this.lines || []).forEach((line) => line.material.color.set(style.getPropertyValue(line.series).trim()));
  }
  moveForces(state) {
    const tool = this.drawing.tissue.header.tool;
    const tip = tool.origin.map((x, c) => x + state.place * tool.direction[c]);
    // The scale halves when a line would be longer than 0.4 of the tissue, and begins again with a reset.
    const most = Math.max(...this.lines.map((line) => Math.abs(state[line.key])));
    if (!this.perNewton) { this.perNewton = 0.16 * this.size; }
    while (most * this.perNewton > 0.4 * this.size) { this.perNewton /= 2; }
    this.lines.forEach((line) => {
      const value = state[line.key];
      const length = Math.abs(value) * this.perNewton;
      line.group.visible = length > 0.003 * this.size;
      // The line of the hand ends at the tip if it pushes; all others begin there.
      const back = line.inwards && value > 0 ? length + 0.03 * this.size : 0;
      line.group.position.set(...tip.map((x, c) => x - back * tool.direction[c] + (c === 0 ? line.aside : 0)));
      line.group.scale.y = value < 0 ? -1 : 1;
      line.shaft.scale.y = Math.max(length, 1e-6);
      line.head.position.y = length;
      line.says.textContent = inWords(Math.abs(value) < 5e-4 ? 0 : value, 'N');
    });
    const scale = this.find('lines-scale');
    const pixels = this.perNewton * this.pixelsPerMetre();  // of 1 N
    const shown = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20].find((force) => force * pixels >= 30) || 50;
    scale.textContent = inWords(shown, 'N');
    scale.style.setProperty('--length', (shown * pixels).toFixed(1) + 'px');
  }
  // Pixels of a metre at the tool's entry, across the line of sight.
  pixelsPerMetre() {
    const camera = this.drawing.camera, canvas = this.drawing.canvas;
    const at = new THREE.Vector3(...this.drawing.tissue.header.tool.origin);
    const aside = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0).multiplyScalar(0.01).add(at);
    const a = at.project(camera), b = aside.project(camera);
    return Math.hypot((b.x - a.x) * canvas.clientWidth, (b.y - a.y) * canvas.clientHeight) / 2 / 0.01;
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
    if (this.state && state.run !== this.state.run) { this.force.clear(); this.pressure.clear(); this.target = undefined; this.perNewton = 0; }
    this.root.dataset.run = state.run;
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
    if (this.lines) { this.moveForces(state); }
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
      : state.ended === 1 ? 'The longest run is over. Reset begins again.'
      : state.too_slow ? 'Paused without force: this computer cannot compute a tick within ' + inWords(this.about.period, 's') +
        ', and a device needs real time. Take fewer nodes or a smaller simulation.near_radius.'
      : state.pace < 0.9 ? 'Slow motion, ' + Math.round(100 * state.pace) + ' % of real time: this computer cannot compute a tick within ' +
        inWords(this.about.period, 's') + '. ' + state.left_out.toFixed(1) + ' s were left out so far.' : '';
    this.find('warning').hidden = !warning;
    this.find('warning').textContent = warning;
    if (this.about.tool) { this.sayGrip(state); }
    const materials = state.changing === 2 ? 'Takes effect at the next reset: the state cannot be carried over to these materials.'
      : state.changing && !state.running ? 'Takes effect when the run goes on.'
      : state.changing ? 'Is being prepared.' : state.changed >= 0 ? 'Changed at ' + secondsInWords(state.changed) + '.' : '';
    if (this.find('materials-says').textContent !== materials) { this.find('materials-says').textContent = materials; }
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
      'use the wheel once the picture was clicked.';
    why.hidden = true;
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', function () {
      drawing.followTheme();
      live.colourForces();
      controls.set({});
    });
    new ResizeObserver(() => requestAnimationFrame(() => drawing.draw())).observe(canvas);
    const live = new Live(about, drawing, controls);
  } catch (problem) {
    why.textContent = 'No live view: ' + problem.message + '.';
    document.getElementById('live').dataset.state = 'failed';
  }
}
startLive();
