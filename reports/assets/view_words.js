// Numbers as people read them: three or four digits and the prefix that they would choose.
function inWords(value, unit) {
  const size = Math.abs(value);
  const prefixes = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
  if (size < 1e-12) { return '0\u00a0' + (unit === 'm' ? 'mm' : unit); }
  const [factor, prefix] = prefixes.find((each) => size >= 0.9995 * each[0]) || prefixes[prefixes.length - 1];
  return String(+(value / factor).toPrecision(3)).replace('-', '−') + '\u00a0' + prefix + unit;
}

function secondsInWords(value) { return value.toFixed(3) + '\u00a0s'; }
