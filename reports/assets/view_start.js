// Starts the view, or says why there is none; the still pictures are there in any case.
async function startView() {
  const why = document.getElementById('view-why');
  const body = document.getElementById('view-body');
  try {
    if (typeof DecompressionStream === 'undefined') { throw new Error('this browser cannot inflate data'); }
    const text = (id) => document.getElementById(id).textContent;
    const script = document.createElement('script');
    script.textContent = new TextDecoder().decode(await inflate(text('view-three')));
    document.head.append(script);
    const header = JSON.parse(text('view-header'));
    const tissue = new Tissue(header, await inflate(text('view-numbers')));
    const canvas = document.getElementById('view-canvas');
    if (!document.createElement('canvas').getContext('webgl')) { throw new Error('this browser offers no WebGL'); }
    body.hidden = false;
    const drawing = new Drawing(canvas, tissue);
    const camera = new ViewCamera(drawing);
    const controls = new Controls(drawing, camera);
    const redraw = () => requestAnimationFrame(() => drawing.draw());
    new ResizeObserver(redraw).observe(canvas);
    canvas.addEventListener('webglcontextrestored', redraw);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', function () {
      drawing.followTheme();
      controls.set({});
    });
    why.hidden = true;
    document.getElementById('view').dataset.state = 'ready';
    return controls;
  } catch (problem) {
    body.hidden = true;
    why.textContent = 'No view in three dimensions: ' + problem.message +
      '. The still pictures below show the same run.';
    document.getElementById('view').dataset.state = 'stills';
    return null;
  }
}
startView();
