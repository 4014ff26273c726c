// Makes the plots when their section is unfolded, as they need a size; colours are the page's.
function zoomPlots(makeAll) {
  var section = document.querySelector('details.zooms');
  var style = getComputedStyle(document.documentElement);
  function colour(name) { return style.getPropertyValue(name).trim(); }
  function brief(value) { return String(+value.toPrecision(4)); }
  function plot(id, data, labels, colours, unit) {
    new Dygraph(document.getElementById(id), data, {
      labels: labels,
      colors: colours.map(function (n) { return colour('--series-' + n); }),
      xlabel: labels[0],
      ylabel: unit,
      strokeWidth: 1.6,
      legend: 'always',
      labelsDiv: document.getElementById(id + '-legend'),
      gridLineColor: colour('--grid'),
      axisLineColor: colour('--soft'),
      axes: {
        x: { valueFormatter: brief },
        y: { axisLabelWidth: 78, axisLabelFormatter: brief, valueFormatter: brief }
      }
    });
  }
  section.addEventListener('toggle', function () { makeAll(plot); }, { once: true });
}
