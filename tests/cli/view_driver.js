// Operates the view of a page as a person would, and leaves what it found in the document.
(function () {
  const problems = [];
  const unchanged = [];
  window.addEventListener('error', (event) => problems.push(event.message));
  window.addEventListener('unhandledrejection', (event) => problems.push(String(event.reason)));
  document.addEventListener('securitypolicyviolation', (event) => problems.push('asked for ' + event.blockedURI));
  ['error', 'warn'].forEach(function (kind) {
    const before = console[kind];
    console[kind] = function () { problems.push(Array.from(arguments).join(' ')); before.apply(console, arguments); };
  });
  const find = (name) => document.getElementById('view-' + name);
  const small = document.createElement('canvas');
  small.width = 200;
  small.height = 150;
  const paint = small.getContext('2d', { willReadFrequently: true });
  // The picture as it was drawn in this very task, before the browser clears it.
  function picture() {
    paint.clearRect(0, 0, small.width, small.height);
    paint.drawImage(find('canvas'), 0, 0, small.width, small.height);
    return paint.getImageData(0, 0, small.width, small.height).data;
  }
  function apart(a, b) {
    let count = 0;
    for (let n = 0; n < a.length; n += 4) {
      let sum = 0;
      for (let c = n; c < n + 4; ++c) { sum += Math.abs(a[c] - b[c]); }
      count += sum > 24 ? 1 : 0;
    }
    return count;
  }
  function choose(element, value) {
    element.value = value;
    element.dispatchEvent(new Event(element.tagName === 'SELECT' ? 'change' : 'input', { bubbles: true }));
  }
  function mustChange(what, act) {
    const before = picture();
    act();
    const changed = apart(before, picture());
    if (changed < 20) { unchanged.push(what + ' (' + changed + ' pixels)'); }
  }
  // Pixels that the tool takes in the picture.
  function pixelsOfTool() {
    const box = find('show-tool');
    box.click();  // draws
    const hidden = picture();
    box.click();
    return apart(hidden, picture());
  }
  // The share of the tool that is seen when the page opens: the cut lies open along it.
  function judgeTool() {
    if (!find('show-tool')) { return; }
    const seen = pixelsOfTool();
    const skin = document.querySelector('#view-layers input');
    find('show-body').click();
    choose(skin, 0);
    const all = pixelsOfTool();
    find('show-body').click();
    choose(skin, 1);
    if (all < 20 || seen < 0.9 * all) { unchanged.push('tool: ' + seen + ' of ' + all + ' pixels are seen'); }
  }
  function operate() {
    judgeTool();
    const frame = find('frame');
    choose(frame, 0);
    const first = picture();
    const colours = new Set();
    for (let n = 0; n < first.length; n += 4) { colours.add(first[n] << 16 | first[n + 1] << 8 | first[n + 2]); }
    choose(find('colour'), 'tissue');  // so that only movement is seen, and that of the nodes
    if (find('show-tool')) { find('show-tool').click(); }
    choose(find('enlarge'), 20);  // stiff tissue moves by less than a pixel
    mustChange('nodes over time', () => choose(frame, Math.floor(frame.max / 2)));
    if (find('time').textContent === '') { problems.push('no time is told'); }
    mustChange('colour by displacement', () => choose(find('colour'), 'displacement'));
    mustChange('colour by force', () => choose(find('colour'), 'force'));
    const body = find('show-body');
    if (body) {
      mustChange('no cut', () => choose(find('axis'), -1));
      mustChange('cut along x', () => choose(find('axis'), 0));
      mustChange('sagittal cut', () => choose(find('axis'), 1));
      mustChange('place of the cut', () => choose(find('cut'), Number(find('cut').value) + 0.006));
      mustChange('tissue hidden', () => body.click());
    }
    ['nodes', 'springs', 'lines'].forEach((part) => mustChange(part, () => find('show-' + part).click()));
    if (body) { body.click(); }
    document.querySelectorAll('#view-layers input').forEach(function (slider, n) {
      if (body && n < 2) { mustChange('opacity ' + n, () => choose(slider, 0.1)); }
    });
    const key = (name) => find('canvas').dispatchEvent(new KeyboardEvent('keydown', { key: name, bubbles: true }));
    const before = frame.value;
    key('.');
    if (Number(frame.value) !== Number(before) + 1) { unchanged.push('key "."'); }
    return colours.size;
  }
  function report(words) {
    const found = document.createElement('pre');
    found.id = 'found';
    found.textContent = words + ' stills=' + document.querySelectorAll('.stills svg[role=img]').length +
      ' problems=' + (problems.join('; ') || 'none');
    document.body.append(found);
  }
  let patience = 400;
  const timer = setInterval(function () {
    const state = document.getElementById('view').dataset.state;
    if (!state && --patience > 0) { return; }
    clearInterval(timer);
    let words = 'state=' + state + ' requests=' + performance.getEntriesByType('resource').length;
    if (state === 'ready') {
      try {
        const colours = operate();
        words += ' colours=' + colours + ' blank=' + (colours < 20 ? 'yes' : 'no') +
          ' unchanged=' + (unchanged.join('; ') || 'none');
      } catch (problem) { problems.push(problem.stack); }
    } else { words += ' says=' + find('why').textContent; }
    report(words);
  }, 100);
})();
