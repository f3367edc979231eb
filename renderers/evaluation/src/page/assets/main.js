// The beginning: the data has come, and the address says what is shown.
"use strict";

{
  const app = document.getElementById("app");
  let own = null;

  /** Shows what the address says. */
  function route() {
    if (location.hash === own) return;
    own = location.hash;
    if (location.hash.startsWith("#view") && ltsc.book.scenes.length > 0) {
      if (!document.querySelector(".viewer")) {
        ltsc.state.take(location.hash);
        ltsc.viewer.build(app);
      } else {
        ltsc.state.take(location.hash);
      }
      document.body.className = "viewing";
    } else if (location.hash === "#main") {
      document.getElementById("main")?.focus();
    } else {
      document.body.className = "";
      ltsc.index.build(app);
    }
  }

  /** Keeps the address as what is shown, without a step back for each change. */
  function keep() {
    const link = ltsc.state.link();
    if (link === location.hash || !document.querySelector(".viewer")) return;
    own = link;
    try {
      history.replaceState(null, "", link);
    } catch {
      location.replace(link);
    }
    // The browser may write some letters otherwise.
    own = location.hash;
  }

  /** Called by the script of the data. */
  ltsc.model = (book) => {
    ltsc.book = book;
    let soon = null;
    ltsc.state.listen(() => {
      if (!document.querySelector(".viewer")) return;
      ltsc.viewer.refresh();
      clearTimeout(soon);
      soon = setTimeout(keep, 150);
    });
    window.addEventListener("hashchange", route);
    own = null;
    route();
    ltsc.ready = true;
  };
}
