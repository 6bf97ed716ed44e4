/** The server-sent events of one job, for as long as the page shows it. */

const TYPES = ["state", "tile", "error"];
const LONGEST_PAUSE = 8000; // milliseconds

/**
 * Follows the events at `url` until the signal aborts.
 *
 * onOpen() runs at every connection: events may have been missed, so read the state of things afresh.
 * onEvent(type, data) runs for each event, onLost() when the connection breaks. It is made again for as
 * long as it takes; `reopen()` on the result drops one that has gone quiet, `close()` ends it.
 *
 * The stream is closed while the page is hidden: over HTTP/1.1 a browser opens six connections to a
 * server in all, and every tab left open would hold one of them.
 */
export function follow(url, { onOpen, onEvent, onLost, signal }) {
  let source = null;
  let timer = 0;
  let pause = 500;
  let ended = false;

  function open() {
    drop();
    if (ended || document.hidden) return;
    source = new EventSource(url);
    source.onopen = () => {
      pause = 500;
      onOpen();
    };
    for (const type of TYPES) source.addEventListener(type, (event) => receive(type, event));
  }

  function receive(type, event) {
    if (event.data === undefined) return broken(); // the browser's own "error": no message, but the connection
    let data;
    try {
      data = JSON.parse(event.data);
    } catch {
      return; // cut off in the middle of a restart; onOpen reads everything afresh
    }
    onEvent(type, data);
  }

  function broken() {
    // The browser tries again by itself (and tells the server the last event it saw), except where an
    // answer came that was not an event stream, as from a proxy whose server is away.
    if (source.readyState === EventSource.CLOSED) {
      drop();
      timer = setTimeout(open, pause * (0.75 + Math.random() / 2));
      pause = Math.min(pause * 2, LONGEST_PAUSE);
    }
    onLost();
  }

  function drop() {
    clearTimeout(timer);
    source?.close();
    source = null;
  }

  function close() {
    ended = true;
    drop();
  }

  document.addEventListener("visibilitychange", () => (document.hidden ? drop() : open()), { signal });
  signal.addEventListener("abort", close, { once: true });
  open();
  return { reopen: open, close };
}
