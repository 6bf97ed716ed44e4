/** Work that is repeated while a view is shown. */

/**
 * Runs `work` now and then again `pause()` milliseconds after it ended (Infinity: never again, whoever asks), until the
 * signal aborts. Rests while the page is hidden, and runs at once when it is shown again. `soon()` on the result asks for
 * a run as soon as `least` milliseconds have passed since the last one began.
 */
export function poll(work, { pause, least = 1000, signal }) {
  let timer = 0;
  let running = false;
  let again = false;
  let began = -Infinity;

  async function run() {
    clearTimeout(timer);
    if (signal.aborted || document.hidden || pause() === Infinity) return;
    if (running) {
      again = true;
      return;
    }
    running = true;
    again = false;
    began = performance.now();
    try {
      await work();
    } finally {
      running = false;
      plan(again ? wait() : pause());
    }
  }

  function wait() {
    return Math.max(0, began + least - performance.now());
  }

  function plan(milliseconds) {
    clearTimeout(timer);
    if (!signal.aborted && milliseconds < Infinity) timer = setTimeout(run, milliseconds);
  }

  function soon() {
    if (running) again = true;
    else plan(wait());
  }

  document.addEventListener("visibilitychange", run, { signal });
  signal.addEventListener("abort", () => clearTimeout(timer), { once: true });
  run();
  return { soon };
}
