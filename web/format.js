/** Numbers as a person reads them. */

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** Seconds: "42 ms", "3.2 s", "12 s", "3 min 05 s", "2 h 10 min", "3 d 4 h". */
export function duration(seconds) {
  if (!Number.isFinite(seconds) || seconds < 0) return "–";
  if (seconds === 0) return "0 s";
  if (seconds < 0.9995e-3) return `${Number((seconds * 1e6).toPrecision(2))} µs`;
  if (seconds < 0.9995) return `${Number((seconds * 1e3).toPrecision(2))} ms`;
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, "0")} s`;
  const minutes = Math.round(whole / 60);
  if (minutes < 24 * 60) return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
  const hours = Math.round(minutes / 60);
  return `${Math.floor(hours / 24)} d ${hours % 24} h`;
}

/** A count in groups of three digits: 16 777 216. */
export function count(number) {
  if (!Number.isFinite(number)) return "–";
  return Math.round(number).toString().replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

/** A large number with a unit prefix: 12.3 M. */
export function short(number) {
  if (!Number.isFinite(number)) return "–";
  for (const [scale, prefix] of [[1e12, "T"], [1e9, "G"], [1e6, "M"], [1e3, "k"]]) {
    if (Math.abs(number) >= scale) return `${(number / scale).toPrecision(3)}\u202f${prefix}`;
  }
  return `${Number(number.toPrecision(3))}`;
}

/** Bytes: 12.3 MB. */
export function bytes(number) {
  return Number.isFinite(number) ? `${short(number)}${number < 1000 ? "\u202f" : ""}B` : "–";
}

/** Two digits and a power of ten: 3.2·10⁻⁴. */
export function scientific(number, digits = 2) {
  if (number === null || number === undefined || !Number.isFinite(number)) return "–";
  if (number === 0) return "0";
  const [mantissa, exponent] = number.toExponential(digits - 1).split("e");
  return `${mantissa}·${power(Number(exponent))}`;
}

/** An interval, with a digit more than its middle is given with: it may be narrow. */
export function interval(low, high) {
  return `${scientific(low, 3)} to ${scientific(high, 3)}`;
}

/** 10⁻⁴ for -4. */
export function power(exponent) {
  const digits = Array.from(String(Math.abs(exponent)), (digit) => SUPERSCRIPTS[digit]).join("");
  return `10${exponent < 0 ? "⁻" : ""}${digits}`;
}

/** "just now", "5 min ago", or the date, of an ISO time. */
export function when(iso, now = Date.now()) {
  const time = Date.parse(iso);
  if (!Number.isFinite(time)) return "–";
  const minutes = (now - time) / 60_000;
  if (minutes < 1) return "just now";
  if (minutes < 60) return `${Math.floor(minutes)} min ago`;
  if (minutes < 24 * 60) return `${Math.floor(minutes / 60)} h ago`;
  return new Date(time).toLocaleDateString(undefined, { year: "numeric", month: "short", day: "numeric" });
}

export function percent(fraction) {
  // 100% is kept for what is complete.
  return `${fraction >= 1 ? 100 : Math.min(99, Math.floor(fraction * 100))}%`;
}
