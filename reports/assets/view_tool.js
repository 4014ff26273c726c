// The tool as a body that slides along its line: needle, fingertip or ultrasound probe.
function toolBody(about) {
  const tool = new THREE.Group();
  const metal = new THREE.MeshPhongMaterial({ color: 0xc9d2da, specular: 0xffffff, shininess: 60 });
  const skin = new THREE.MeshPhongMaterial({ color: 0xd9a58a, specular: 0x332222, shininess: 12 });
  const dark = new THREE.MeshPhongMaterial({ color: 0x3d4a57, specular: 0x666666, shininess: 30 });
  // A body of turned profile: points (radius, height above the tip).
  const turned = function (profile, material) {
    const points = profile.map((p) => new THREE.Vector2(p[0], p[1]));
    tool.add(new THREE.Mesh(new THREE.LatheBufferGeometry(points, 40), material));
  };
  const [width, breadth] = about.size;
  const r = width / 2;
  if (about.shape === 'needle') {
    turned([[0, 0], [r, 4 * r], [r, 0.085]], metal);
    turned([[r, 0.085], [0.0022, 0.087], [0.0032, 0.1], [0, 0.1]], dark);
  } else if (about.shape === 'fingertip') {
    const round = [[0, 0], [0.86 * r, 0]];
    for (let n = 1; n <= 8; ++n) {
      round.push([r * (0.86 + 0.14 * Math.sin(n * Math.PI / 16)), 0.3 * r * (1 - Math.cos(n * Math.PI / 16))]);
    }
    turned(round.concat([[r, 3.2 * r], [0.96 * r, 5 * r], [0, 5 * r]]), skin);
  } else {
    const head = new THREE.Mesh(new THREE.BoxBufferGeometry(width, 0.02, breadth), dark);
    head.position.y = 0.01;
    const handle = new THREE.Mesh(new THREE.BoxBufferGeometry(0.7 * width, 0.05, 0.9 * breadth), metal);
    handle.position.y = 0.045;
    tool.add(head, handle);
  }
  const outwards = new THREE.Vector3(...about.direction).negate();
  tool.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), outwards);
  return tool;
}
