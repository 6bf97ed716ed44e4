/** Half-precision floats (IEEE 754 binary16), and what becomes of them on a screen. */

/** The value of a half float given by its 16 bits. */
export function fromHalf(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 0x1f;
  const fraction = bits & 0x3ff;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

/** Ways from linear light to [0, 1]. `clip` is what image.png does. */
const OPERATORS = {
  clip: (light) => Math.min(light, 1),
  // Reinhard et al. 2002, per channel: keeps detail in what is brighter than white.
  compress: (light) => (light === Infinity ? 1 : light / (1 + light)),
};

/**
 * A table from each of the 65,536 half floats to an 8-bit sRGB value (IEC 61966-2-1), so that a whole
 * picture is developed anew with one look-up for each value. exposure: stops.
 */
export function toneTable(exposure, operator) {
  const apply = OPERATORS[operator];
  const gain = 2 ** exposure;
  const table = new Uint8ClampedArray(65536); // rounds to nearest; negative numbers and NaN stay 0
  for (let bits = 0; bits < 0x8000; bits += 1) {
    const light = fromHalf(bits) * gain;
    if (Number.isNaN(light)) continue;
    const level = apply(light);
    const encoded = level <= 0.0031308 ? 12.92 * level : 1.055 * level ** (1 / 2.4) - 0.055;
    table[bits] = Math.floor(255 * encoded + 0.5);
  }
  return table;
}
