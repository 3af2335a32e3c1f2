// plotly.js, most of a page, travels compressed. Unpacked it is a script like the others, which the
// page's policy knows by its hash.
const unpackLibrary = async () => {
  const packed = atob(document.getElementById("library").textContent);
  const bytes = new Uint8Array(packed.length);
  for (let place = 0; place < packed.length; place += 1) bytes[place] = packed.charCodeAt(place);
  const program = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const script = element("script");
  script.textContent = await new Response(program).text();
  document.head.append(script);
  if (!window.Plotly) throw new Error("plotly.js did not run");
};

// One image after another is loaded until the function returned is called: the page is not complete
// before. What prints it from a command line, as soon as it is complete, finds its plots.
const holdLoad = () => {
  const image = new Image();
  let waiting = true, count = 0;
  const next = () => {
    count += 1;
    if (waiting) image.src = `data:image/svg+xml,<svg xmlns="http://www.w3.org/2000/svg" id="i${count}"/>`;
  };
  image.addEventListener("load", next);
  next();
  return () => { waiting = false; };
};
