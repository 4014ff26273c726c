// From the text of the page to numbers, as reports/packed_bytes.hpp wrote them.
function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let n = 0; n < text.length; ++n) { bytes[n] = text.charCodeAt(n); }
  return bytes;
}

async function inflate(base64) {
  const packed = new Blob([bytesOf(base64)]).stream();
  const stream = packed.pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Reads one part after the other.
class ByteReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.place = 0;
  }
  plane(count) {
    this.place += count;
    return this.bytes.subarray(this.place - count, this.place);
  }
  // Whole numbers whose differences were kept in planes of bytes.
  differences(count, bits) {
    const planes = [];
    for (let shift = 0; shift < bits; shift += 8) { planes.push(this.plane(count)); }
    const values = new Int32Array(count);
    const unused = 32 - bits;
    for (let n = 0, before = 0; n < count; ++n) {
      let value = 0;
      for (let p = 0; p < planes.length; ++p) { value |= planes[p][n] << (8 * p); }
      before = (before + value) << unused >>> unused;
      values[n] = before;
    }
    return values;
  }
  // One coordinate of places in a box.
  places(box, count, axis, into) {
    const steps = this.differences(count, 16);
    for (let n = 0; n < count; ++n) { into[3 * n + axis] = box.low[axis] + steps[n] / 65535 * box.extent[axis]; }
  }
  // 16-bit numbers, as differences to others in the same places.
  changes(before) {
    const low = this.plane(before.length);
    const high = this.plane(before.length);
    return Int16Array.from(before, function (value, n) { return value + (low[n] | high[n] << 8); });
  }
}
