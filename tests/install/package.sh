#!/usr/bin/env bash
# package.sh CPACK SOURCE BUILD SCRATCH VERSION: builds the Debian package, extracts it, and runs the program from there.
set -euo pipefail
cpack=$1 source=$2 build=$3 out=$4 version=$5
fail() { echo "$*" >&2; exit 1; }
rm -rf "$out"
mkdir -p "$out"
"$cpack" --config "$build/CPackConfig.cmake" -B "$out/made" >"$out/log" 2>&1 || fail "$(cat "$out/log")"
package=$(echo "$out"/made/palpate_"$version"_*.deb)
[ -f "$package" ] || fail "no package of version $version: $(ls "$out/made")"
dpkg-deb -f "$package" Version Depends >"$out/control"
grep -q "^Version: $version$" "$out/control" || fail "$(cat "$out/control")"
if command -v dpkg-shlibdeps >/dev/null; then
  for needed in libgsl libhdf5 libsundials; do
    grep -q "$needed" "$out/control" || fail "$needed is not among the packages needed: $(cat "$out/control")"
  done
fi

root=$out/root
dpkg-deb -x "$package" "$root"
usr=$root/usr
for file in bin/palpate bin/palpate-subject-host lib/palpate/palpate_subject_model.so lib/libpalpate_model.a \
  lib/libpalpate_device.a lib/cmake/palpate/palpate-config.cmake include/palpate/palpate_subject.h \
  include/palpate/model/stepping/simulation.hpp share/man/man1/palpate.1 share/bash-completion/completions/palpate \
  share/zsh/vendor-completions/_palpate share/fish/vendor_completions.d/palpate.fish share/palpate/scene.schema.json \
  share/palpate/scenes/mri-example/scene.toml share/doc/palpate/copyright share/doc/palpate/LICENSE \
  share/doc/palpate/CHANGELOG.md share/doc/palpate/docs/scenes.md; do
  [ -s "$usr/$file" ] || fail "the package lacks /usr/$file"
done
[ ! -e "$usr/share/palpate/scenes/invalid" ] || fail "the package holds scenes of the tests"
if grep -rqF "$source" "$usr/lib/cmake" "$usr/share" ; then fail "the package names the source folder"; fi

# The program from there, without the source tree: what it is, a shipped scene, a scene of its own, a case.
palpate=$usr/bin/palpate
cd "$out"
"$palpate" --version | grep -q "^palpate $version " || fail "another version"
"$palpate" run "$usr/share/palpate/scenes/mri-example/scene.toml" --set simulation.duration=0.01 -q -o run >/dev/null
"$palpate" init needle -o first >/dev/null
"$palpate" inspect first/scene.toml >/dev/null
"$palpate" validate oscillator/order/leapfrog --quick -q --cache cache -o validate >/dev/null
"$palpate" subject check "$usr/lib/palpate/palpate_subject_model.so" --help >/dev/null

# Shells and man read what the program says of itself. Those that are not installed are left out.
bash -n "$usr/share/bash-completion/completions/palpate"
if command -v zsh >/dev/null; then zsh -n "$usr/share/zsh/vendor-completions/_palpate"; fi
if command -v fish >/dev/null; then fish -n "$usr/share/fish/vendor_completions.d/palpate.fish"; fi
if command -v groff >/dev/null; then
  groff -Tutf8 -man -ww "$usr/share/man/man1/palpate.1" >page 2>warnings
  [ ! -s warnings ] || fail "the manual page: $(cat warnings)"
fi
for command in run validate "subject check" completion; do
  grep -qx "\.B ${command}" "$usr/share/man/man1/palpate.1" || fail "the manual page lacks $command"
done

# What bash completes.
complete() {
  bash -c 'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _palpate; echo "${COMPREPLY[*]}"' \
    "$usr/share/bash-completion/completions/palpate" "$@"
}
[ "$(complete palpate va)" = validate ] || fail "va: $(complete palpate va)"
[ "$(complete palpate run --real)" = --real-time ] || fail "run --real: $(complete palpate run --real)"
[ "$(complete palpate subject check --in)" = --in-process ] || fail "subject check --in: $(complete palpate subject check --in)"
[ "$(complete palpate inspect fir)" = first ] || fail "a file: $(complete palpate inspect fir)"
