// plotly.js, most of a page, travels compressed. Unpacked it is a script like the others, which the
// page's policy knows by its hash.
const canUnpack = "DecompressionStream" in window;

const unpackLibrary = async () => {
  const packed = atob(document.getElementById("library").textContent);
  const bytes = new Uint8Array(packed.length);
  for (let place = 0; place < packed.length; place += 1) bytes[place] = packed.charCodeAt(place);
  const program = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const script = element("script");
  script.textContent = await new Response(program).text();
  document.head.append(script);
};
