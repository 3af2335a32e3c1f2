// The state of the page lives in its address: #scene-3?quantity=force&load.scene-3=2&sort.T=4d
// Whoever opens such a link sees what its sender saw. (All parts of the program share one scope.)
const state = (() => {
  const read = () => {
    const [anchor, query = ""] = location.hash.slice(1).split("?");
    return [decodeURIComponent(anchor), query];
  };
  let [anchor, query] = read();
  let values = new URLSearchParams(query);
  const listeners = [];
  let later = null;
  const write = () => {
    clearTimeout(later);
    later = null;
    const text = values.toString();
    const hash = "#" + encodeURIComponent(anchor) + (text ? "?" + text : "");
    if (hash !== (location.hash || "#")) history.replaceState(null, "", hash);
  };
  const show = () => {
    const target = anchor && document.getElementById(anchor);
    if (!target) return;
    // A link into folded text opens it, however deep; one to a folded section opens that.
    for (let outer = target.closest("details"); outer; outer = outer.parentElement.closest("details")) outer.open = true;
    const body = target.querySelector(":scope > details.scene-body");
    if (body) body.open = true;
    target.scrollIntoView({ behavior: "instant" });
  };
  window.addEventListener("hashchange", () => {
    const [to, asked] = read();
    anchor = to;
    if (asked) {
      values = new URLSearchParams(asked);
      for (const listener of listeners) listener();
      show();
    } else {
      // A link inside the page keeps what is filtered and sorted.
      show();
      write();
    }
  });
  return {
    get: (key) => values.get(key),
    // While something moves the address follows late: a browser takes few new ones in a second.
    set(key, value, element, moves = false) {
      if (value === null || value === "") values.delete(key);
      else values.set(key, value);
      anchor = element?.closest("section[id]")?.id ?? anchor;
      if (moves) later ??= setTimeout(write, 200);
      else write();
    },
    // Call `listener` now, and whenever another link is followed.
    follow(listener) {
      listeners.push(listener);
      listener();
    },
    show,
  };
})();

const element = (tag, attributes = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
};
const button = (text, label, act) => {
  const made = element("button", { type: "button", "aria-label": label }, text);
  made.addEventListener("click", act);
  return made;
};
const slug = (text) => text.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 60) || "roughline";

// What is folded to keep the screen short is printed.
const unfolded = [];
window.addEventListener("beforeprint", () => {
  unfolded.push(...document.querySelectorAll("details.printed:not([open])"));
  for (const fold of unfolded) fold.open = true;
});
window.addEventListener("afterprint", () => {
  for (const fold of unfolded.splice(0)) fold.open = false;
});
