// How nodes, springs and the sides of cells are painted. Colour comes from a scale or from the tissue;
// what lies before the plane of the cut is left out, judged by undeformed places.
const seenByAll = `
uniform float opacity[32];
uniform vec4 cut;
uniform sampler2D scale;
uniform sampler2D tissueColours;
uniform float scaled;
uniform float own;
attribute vec3 rest;
attribute float label;
attribute float share;
varying vec4 paint;
varying float hidden;
void prepare() {
  vec4 byScale = texture2D(scale, vec2(clamp(share, 0.0, 1.0) * 0.998 + 0.001, 0.5));
  float kind = own < 0.0 ? label : own;  // a side is of its cell's kind, whatever its corners are
  vec4 byTissue = texture2D(tissueColours, vec2((kind + 0.5) / 32.0, 0.5));
  paint = vec4(mix(byTissue.rgb, byScale.rgb, scaled), opacity[int(kind + 0.5)]);
  hidden = dot(rest, cut.xyz) > cut.w ? 1.0 : 0.0;
}`;

const sideShaders = {
  vertex: seenByAll + `
varying vec3 seenAt;
void main() {
  prepare();
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  seenAt = seen.xyz;
  gl_Position = projectionMatrix * seen;
}`,
  fragment: `
varying vec4 paint;
varying vec3 seenAt;
void main() {
  vec3 normal = normalize(cross(dFdx(seenAt), dFdy(seenAt)));
  float light = 0.76 + 0.24 * abs(dot(normal, normalize(vec3(0.25, 0.55, 0.8))));
  gl_FragColor = vec4(paint.rgb * light, paint.a);
}`
};

const nodeShaders = {
  vertex: seenByAll + `
uniform float size;
void main() {
  prepare();
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * seen;
  gl_PointSize = hidden > 0.5 ? 0.0 : clamp(size / -seen.z, 2.0, 40.0);
}`,
  fragment: `
varying vec4 paint;
varying float hidden;
void main() {
  vec2 away = 2.0 * gl_PointCoord - 1.0;
  float square = dot(away, away);
  if (square > 1.0 || hidden > 0.5 || paint.a < 0.01) { discard; }
  float light = 0.45 + 0.55 * (0.35 * -away.y + sqrt(1.0 - square));
  gl_FragColor = vec4(paint.rgb * min(light, 1.1), paint.a);
}`
};

const lineShaders = {
  vertex: seenByAll + `
uniform float nearer;
void main() {
  prepare();
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z -= nearer * gl_Position.w;
}`,
  fragment: `
uniform vec4 ink;
varying vec4 paint;
varying float hidden;
void main() {
  if (hidden > 0.5 || paint.a < 0.01) { discard; }
  gl_FragColor = vec4(mix(paint.rgb, ink.rgb, ink.a), 1.0);
}`
};

// Force lines: here the share is a sign, 1 for a pull, -1 for a push, 0 for what is too little to show.
const strokeShaders = {
  vertex: seenByAll + `
uniform float nearer;
varying float sense;
void main() {
  prepare();
  sense = share;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z -= nearer * gl_Position.w;
}`,
  fragment: `
uniform vec3 pull;
uniform vec3 push;
varying vec4 paint;
varying float hidden;
varying float sense;
void main() {
  if (hidden > 0.5 || paint.a < 0.01 || abs(sense) < 0.5) { discard; }
  gl_FragColor = vec4(sense > 0.0 ? pull : push, 1.0);
}`
};
