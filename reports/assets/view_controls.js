// What a person can choose, and what the picture says in words.
class Controls {
  constructor(drawing, camera) {
    this.drawing = drawing;
    this.header = drawing.tissue.header;
    this.find = (name) => document.getElementById('view-' + name);
    const { grid, tool } = this.header;
    const axis = this.tellingAxis();
    camera.side = axis;
    camera.home();
    this.state = {
      frame: this.header.peak, colour: tool && tool.shape === 'needle' ? 'tissue' : 'displacement',
      axis: axis, cut: this.cutAlong(axis), enlarged: this.header.enlargement,
      body: grid, nodes: !grid, springs: !grid, lines: false, tool: true, skin: 1,
      opacity: this.header.labels.map(() => 1)
    };
    this.makeShown();
    this.makeLayers();
    this.makeEnlargements();
    this.makeTime();
    this.find('colour').value = this.state.colour;
    this.find('colour').addEventListener('change', (event) => this.set({ colour: event.target.value }));
    this.find('axis').addEventListener('change', (event) => this.setAxis(Number(event.target.value)));
    this.find('cut').addEventListener('input', (event) => this.set({ cut: Number(event.target.value) }));
    this.find('home').addEventListener('click', function () { camera.home(); camera.redraw(); });
    this.setAxis(this.state.axis);
  }
  // The plane of the first picture: of constant y, or of constant x if that shows more kinds of tissue, such as the
  // vertebrae that a needle passes between.
  tellingAxis() {
    const { grid, tool, labels, extent } = this.header;
    if (!grid && !tool) { return -1; }
    const { rest, label, count } = this.drawing.tissue;
    const kinds = [0, 1].map((axis) => {
      const seen = new Set(), cut = this.cutAlong(axis);
      for (let n = 0; n < count; ++n) {
        if (Math.abs(rest[3 * n + axis] - cut) < 0.02 * extent[axis]) { seen.add(label[n]); }
      }
      return seen.size;
    });
    return tool && labels.length > 1 && kinds[0] > kinds[1] ? 0 : 1;
  }
  // Where a cut along an axis lies open along the tool, or in the middle.
  cutAlong(axis) {
    const { tool, low, extent, frames, cut } = this.header;
    if (axis === 1) { return cut; }
    const seen = Math.max(0, axis);
    if (!tool || axis === 2) { return low[seen] + extent[seen] / 2; }
    const deepest = frames.reduce((most, frame) => Math.max(most, frame.place), 0);
    return tool.origin[seen] + Math.min(0, deepest * tool.direction[seen]);
  }
  make(kind, about, parent) {
    const made = Object.assign(document.createElement(kind), about);
    parent.append(made);
    return made;
  }
  makeShown() {
    const parts = { body: 'tissue', nodes: 'nodes', springs: 'springs', lines: 'force lines', tool: 'tool' };
    Object.entries(parts).forEach(([key, words]) => {
      if ((key === 'body' && !this.header.grid) || (key === 'tool' && !this.header.tool)) { return; }
      const label = this.make('label', {}, this.find('shown'));
      const box = this.make('input', { type: 'checkbox', checked: this.state[key], id: 'view-show-' + key }, label);
      label.append(words);
      box.addEventListener('change', () => this.set({ [key]: box.checked }));
    });
  }
  makeLayers() {
    const row = (words, colour, begin, chosen) => {
      const label = this.make('label', { className: 'view-layer' }, this.find('layers'));
      this.make('i', {}, label).style.setProperty('--swatch', colour);
      this.make('span', { textContent: words }, label);
      const slider = this.make('input', { type: 'range', min: 0, max: 1, step: 0.05 }, label);
      slider.value = begin;
      slider.addEventListener('input', () => chosen(Number(slider.value)));
    };
    if (this.header.surfaces.length) {
      const names = this.header.surfaces.map((each) => each.label + ' surface').join(', ');
      row(names, '#e0ac90', this.state.skin, (value) => this.set({ skin: value }));
    }
    this.header.labels.forEach((words, n) => row(words, this.header.colours.tissue[n], 1, (value) => {
      this.state.opacity[n] = value;
      this.set({});
    }));
  }
  makeEnlargements() {
    const chosen = this.header.enlargement;
    const factors = new Set([0, 1, 2, 5, 10, 20, 50, 100, 1000, chosen]);
    Array.from(factors).sort((a, b) => a - b).forEach((factor) => {
      const words = factor === 0 ? 'none' : factor === 1 ? 'to scale' : factor + ' times';
      this.make('option', { value: factor, textContent: words, selected: factor === chosen }, this.find('enlarge'));
    });
    this.find('enlarge').addEventListener('change', (event) => this.set({ enlarged: Number(event.target.value) }));
  }
  makeTime() {
    const slider = this.find('frame');
    slider.max = this.header.frames.length - 1;
    slider.addEventListener('input', () => this.set({ frame: Number(slider.value) }));
    this.find('play').addEventListener('click', () => this.play(!this.playing));
    this.header.frames.forEach((frame, n) => {
      if (!frame.event) { return; }
      this.make('option', { value: n }, this.find('events'));
      this.makeInstant(frame.event, n);
    });
    this.makeInstant('largest reaction', this.header.peak);
    this.find('canvas').addEventListener('keydown', (event) => {
      const last = this.header.frames.length - 1;
      if (event.key === ' ') { this.play(!this.playing); }
      else if (event.key === ',') { this.set({ frame: Math.max(0, this.state.frame - 1) }); }
      else if (event.key === '.') { this.set({ frame: Math.min(last, this.state.frame + 1) }); }
      else { return; }
      event.preventDefault();
    });
  }
  makeInstant(what, n) {
    const button = this.make('button', { type: 'button' }, this.find('happened'));
    button.textContent = what + ', ' + secondsInWords(this.header.frames[n].time);
    button.addEventListener('click', () => this.set({ frame: n }));
  }
  // Once through in six seconds, at the instants that were kept; nothing is made up between them.
  play(on) {
    clearInterval(this.playing);
    this.playing = 0;
    this.find('play').setAttribute('aria-pressed', String(on));
    this.find('play').textContent = on ? 'Pause' : 'Play';
    if (!on) { return; }
    const last = this.header.frames.length - 1;
    if (this.state.frame === last) { this.set({ frame: 0 }); }
    this.playing = setInterval(() => {
      this.set({ frame: this.state.frame + 1 });
      if (this.state.frame >= last) { this.play(false); }
    }, 6000 / Math.max(1, last));
  }
  setAxis(axis) {
    const slider = this.find('cut');
    const seen = Math.max(0, axis);
    const low = this.header.low[seen], extent = this.header.extent[seen];
    slider.min = low;
    slider.max = low + extent;
    slider.value = this.cutAlong(axis);
    slider.disabled = axis < 0;
    this.find('axis').value = String(axis);
    this.set({ axis: axis, cut: Number(slider.value) });
  }
  set(change) {
    Object.assign(this.state, change);
    this.find('frame').value = this.state.frame;
    this.drawing.show(this.state);
    this.say();
  }
  say() {
    const frame = this.header.frames[this.state.frame];
    this.find('time').textContent = secondsInWords(frame.time);
    this.find('frame').setAttribute('aria-valuetext', secondsInWords(frame.time));
    this.find('cut-says').textContent = this.state.axis < 0 ? '' : inWords(this.state.cut, 'm');
    const tool = this.header.tool;
    const lines = [];
    if (tool) { lines.push('tip ' + inWords(frame.depth, 'm') + ' deep' + (frame.layer ? ', in ' + frame.layer : '')); }
    lines.push('applied ' + inWords(frame.applied, 'N') + (tool ? '' : ' by loads'));
    lines.push('reaction ' + inWords(frame.reaction, 'N') + (tool ? ' on the tool' : ' of what is held (elastic)'));
    const says = this.find('says');
    says.replaceChildren();
    this.make('b', { textContent: 't = ' + secondsInWords(frame.time) }, says);
    lines.forEach((words) => this.make('span', { textContent: words }, says));
    if (frame.event) { this.make('em', { textContent: frame.event }, says); }
    this.explain();
  }
  explain() {
    const legend = this.find('legend');
    legend.replaceChildren();
    const header = this.header;
    const [softest, stiffest] = header.stiffness;
    const about = {
      displacement: ['displacement', (share) => inWords(share * header.displacement, 'm')],
      stiffness: ['stiffness of springs, of nodes their mean',
                  (share) => inWords(softest * Math.pow(stiffest / (softest || 1), share), 'N/m')],
      force: ['largest principal force', (share) => inWords(share * share * header.force, 'N')]
    }[this.state.colour];
    if (about) {
      legend.append(about[0]);
      this.make('i', {}, legend).style.background = 'linear-gradient(90deg,' + header.colours.scale.join() + ')';
      const ticks = this.make('div', { className: 'ticks' }, legend);
      [0, 0.5, 1].forEach((share) => this.make('span', { textContent: about[1](share) }, ticks));
    }
    if (this.state.lines) {
      const key = this.make('div', { className: 'key' }, legend);
      [['pull', 'pull'], ['push', 'push']].forEach(([name, words]) => {
        const colour = this.drawing.lineColours[name].value.getStyle();
        this.make('span', { textContent: words }, key).style.setProperty('--swatch', colour);
      });
    }
    if (this.state.enlarged !== 1) {
      const words = this.state.enlarged ? this.state.enlarged + ' times larger' : 'not drawn';
      this.make('div', { textContent: 'movement ' + words }, legend);
    }
  }
}
