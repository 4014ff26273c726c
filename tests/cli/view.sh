#!/usr/bin/env bash
# A run's page in a real browser: the view draws, time and every part of it change the picture, nothing is asked
# of a network, nothing goes wrong on the console; without WebGL the still pictures stand alone and say why.
# The page is copied with a policy that forbids every request, and with a script that operates it.
set -euo pipefail
palpate=$1 scenes=$2 out=$3 driver=$4
browser=$(command -v chromium || command -v chromium-browser || true)
if [ -z "$browser" ]; then
  echo "skipped: no chromium on this machine"
  exit 77
fi
rm -rf "$out"
mkdir -p "$out"

# operate NAME PAGE [FLAG...]: what the driver found, as text.
operate() {
  local name=$1 page=$2
  shift 2
  local policy="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
  {
    sed "s|<head>|<head><meta http-equiv=\"Content-Security-Policy\" content=\"$policy\">|; /<\/body>/,\$d" "$page"
    printf '<script>%s</script></body></html>\n' "$(cat "$driver")"
  } >"$out/$name.html"
  timeout 1000 "$browser" --headless --no-sandbox --disable-gpu --use-gl=angle --use-angle=swiftshader \
    --enable-unsafe-swiftshader --disable-background-networking --disable-component-update --disable-sync \
    --no-first-run --user-data-dir="$out/$name.profile" --window-size=1280,1000 --virtual-time-budget=60000 "$@" \
    --dump-dom "file://$out/$name.html" >"$out/$name.dom" 2>"$out/$name.log"
  grep -o '<pre id="found">.*' "$out/$name.dom" | sed 's/<pre id="found">//; s/<\/pre>.*//'
}

expect() {  # expect TEXT WORDS: fails loudly
  if ! grep -q -- "$2" <<<"$1"; then
    printf 'expected "%s", found:\n%s\n' "$2" "$1"
    exit 1
  fi
}

"$palpate" run "$scenes/palpation.toml" --set simulation.duration=0.4 --out "$out/palpation" --quiet
"$palpate" run "$scenes/cube.toml" --set simulation.duration=0.1 --out "$out/cube" --quiet
"$palpate" run "$scenes/network-example/scene.toml" --out "$out/network" --quiet
# A needle in layers, at its largest force; a hand drives the second with an emulated Falcon.
"$palpate" run "$scenes/epidural.toml" --set simulation.duration=4 --set tissue.layers.nodes=[6,6] --out "$out/epidural" --quiet
"$palpate" run "$scenes/falcon-soft.toml" --set simulation.duration=1.5 --out "$out/falcon" --quiet
for scene in palpation cube network epidural falcon; do
  found=$(operate "$scene" "$out/$scene/report.html")
  echo "$scene: $found"
  expect "$found" "state=ready"
  expect "$found" "requests=0"
  expect "$found" "problems=none"
  expect "$found" "unchanged=none"
  expect "$found" "blank=no"
done

found=$(operate no-webgl "$out/cube/report.html" --disable-3d-apis)
echo "no WebGL: $found"
expect "$found" "state=stills"
expect "$found" "problems=none"
expect "$found" "says=.*no WebGL"
expect "$found" "stills=2"

"$palpate" run "$scenes/cube.toml" --set simulation.duration=0.1 --no-view --out "$out/without" --quiet
if grep -q 'id="view"' "$out/without/report.html"; then
  echo "--no-view left a view in the page"
  exit 1
fi
