"use strict";
// Draws the charts and turnable views of the page when they come into sight. All data stand in the page.
(() => {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const printing = matchMedia("print");
  // No bar of tools: some of them send the data away.
  const config = { responsive: true, displaylogo: false, displayModeBar: false, showTips: false };

  const unpack = async ({ dtype, deflated, low, step }) => {
    const text = atob(deflated);
    const bytes = new Uint8Array(text.length);
    for (let at = 0; at < text.length; at += 1) bytes[at] = text.charCodeAt(at);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const buffer = await new Response(stream).arrayBuffer();
    const whole = dtype === "u2" ? new Uint16Array(buffer) : new Uint32Array(buffer);
    return step === undefined ? whole : Float32Array.from(whole, (count) => low + count * step);
  };

  const colours = () => {
    const light = !dark.matches || printing.matches;
    const [ink, lines] = light ? ["#1b2430", "#cfd6dd"] : ["#e6eaef", "#3a444f"];
    return { ink, lines };
  };

  const themed = (layout) => {
    const { ink, lines } = colours();
    const axis = (given) => ({ gridcolor: lines, zerolinecolor: lines, linecolor: lines, ...given });
    return {
      margin: { l: 64, r: 24, t: 24, b: 70 },
      // Above the curves, where it can lie on no title.
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
      ...layout,
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: ink, size: 13 },
      xaxis: axis(layout.xaxis),
      yaxis: axis(layout.yaxis),
      ...(layout.xaxis2 ? { xaxis2: axis(layout.xaxis2), yaxis2: axis(layout.yaxis2) } : {}),
    };
  };

  const place = { visible: true, title: { text: "" }, showspikes: false };
  const room = (eye) => {
    const { ink, lines } = colours();
    const axis = (title) => ({ ...place, title: { text: title }, color: ink, gridcolor: lines, showbackground: false });
    return {
      margin: { l: 0, r: 0, t: 0, b: 0 },
      paper_bgcolor: "rgba(0,0,0,0)",
      font: { color: ink },
      scene: {
        aspectmode: "data",
        xaxis: axis("x, mm"),
        yaxis: axis("y, mm"),
        zaxis: { ...axis("z, mm"), nticks: 4 },
        camera: { eye: { x: eye[0], y: eye[1], z: eye[2] } },
      },
    };
  };

  const bar = (text) => {
    const narrow = innerWidth < 640;
    const lying = { orientation: "h", y: 1, yanchor: "top", x: 0.5, title: { text, side: "top" } };
    return { thickness: 12, len: 0.8, ...(narrow ? lying : { title: { text, side: "right" } }) };
  };

  const coloured = async (field) => ({
    intensity: await unpack(field.values),
    intensitymode: field.mode,
    cmin: field.low,
    cmax: field.high,
    colorscale: field.colours,
    reversescale: false,
    colorbar: {
      ...bar(field.unit ? `${field.title}, ${field.unit}` : field.title),
      ...(field.words ? { tickvals: [field.low + 0.25 * (field.high - field.low), field.low + 0.75 * (field.high - field.low)], ticktext: field.words } : { tickvals: null, ticktext: null }),
    },
    hovertemplate: `${field.title}: %{intensity:.4g} ${field.unit}<extra></extra>`,
  });

  // So that paper can make the drawing as wide as itself.
  const scalable = (box) => {
    for (const svg of box.querySelectorAll(".main-svg")) {
      const [width, height] = [svg.getAttribute("width"), svg.getAttribute("height")];
      if (!width || !height) continue;
      svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
      box.style.setProperty("--aspect", String(width / height));
    }
  };

  const drawers = {
    plot: async (box, given) => {
      const drawing = Plotly.newPlot(box, given.data, themed(given.layout), config);
      scalable(box);
      await drawing;
      box.on("plotly_afterplot", () => scalable(box));
      scalable(box);
    },
    scene: async (box, given) => {
      const mesh = { type: "mesh3d", flatshading: false, lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.05 } };
      for (const name of ["x", "y", "z", "i", "j", "k"]) mesh[name] = await unpack(given.mesh[name]);
      Object.assign(mesh, await coloured(given.fields[0]));
      return Plotly.newPlot(box, [mesh], room(given.eye), { ...config, scrollZoom: false });
    },
  };

  const given = (box) => JSON.parse(document.getElementById(box.dataset.from).textContent);

  // The charts' program is large: the page is there to be read before it is loaded.
  const load = () => {
    if (window.Plotly) return;
    const script = document.createElement("script");
    script.textContent = document.getElementById("plotly").textContent;
    document.body.append(script);
  };

  const draw = async (box) => {
    if (box.dataset.drawn) return;
    box.dataset.drawn = "started";
    try {
      load();
      await drawers[box.dataset.kind](box, given(box));
      box.dataset.drawn = "done";
    } catch (error) {
      box.dataset.drawn = "failed";
      box.textContent = `This view cannot be drawn here (${error.message}); the picture and the tables stay.`;
    }
  };

  const switchField = async (box, index) => {
    const field = given(box).fields[index];
    const change = await coloured(field);
    const wrapped = {};
    for (const [key, value] of Object.entries(change)) wrapped[key] = [value];
    box.dataset.field = field.name;
    return Plotly.restyle(box, wrapped, [0]);
  };

  const turn = (box, around, up) => {
    const { eye } = box._fullLayout.scene._scene ? box._fullLayout.scene._scene.getCamera() : box.layout.scene.camera;
    const angle = Math.atan2(eye.y, eye.x) + around;
    const flat = Math.hypot(eye.x, eye.y);
    const far = Math.hypot(flat, eye.z);
    const rise = Math.min(1.5, Math.max(-1.5, Math.atan2(eye.z, flat) + up));
    const next = { x: far * Math.cos(rise) * Math.cos(angle), y: far * Math.cos(rise) * Math.sin(angle), z: far * Math.sin(rise) };
    return Plotly.relayout(box, { "scene.camera.eye": next });
  };

  for (const control of document.querySelectorAll("[data-for]")) {
    const box = document.getElementById(control.dataset.for);
    if (control.tagName === "SELECT") {
      control.addEventListener("change", async () => { await draw(box); await switchField(box, Number(control.value)); });
    } else {
      const [around, up] = control.dataset.turn.split(",").map(Number);
      control.addEventListener("click", async () => { await draw(box); await turn(box, around, up); });
    }
  }

  for (const table of document.querySelectorAll("table[data-cases]")) {
    const filters = [...document.querySelectorAll(`[data-filter="${table.id}"]`)];
    const count = document.getElementById(`${table.id}-count`);
    const rows = [...table.tBodies[0].rows];
    const show = () => {
      let shown = 0;
      for (const row of rows) {
        const fits = filters.every((filter) => {
          if (filter.value === "") return true;
          const cell = row.cells[Number(filter.dataset.column)].dataset.value;
          if (filter.tagName === "SELECT") return cell === filter.value;
          return cell !== "" && (filter.dataset.bound === "least" ? Number(cell) >= Number(filter.value) : Number(cell) <= Number(filter.value));
        });
        row.hidden = !fits;
        shown += fits ? 1 : 0;
      }
      count.textContent = `${shown} of ${rows.length} cases shown`;
    };
    for (const filter of filters) for (const event of ["input", "change"]) filter.addEventListener(event, show);
    show();
  }

  const boxes = [...document.querySelectorAll(".plot, .scene")];
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) { watcher.unobserve(entry.target); draw(entry.target); }
  }, { rootMargin: "200px" });
  setTimeout(() => { for (const box of boxes) watcher.observe(box); }, 30);

  const repaint = () => {
    for (const box of boxes.filter((one) => one.dataset.drawn === "done")) {
      const { ink, lines } = colours();
      const change = box.dataset.kind === "scene"
        ? { "font.color": ink, "scene.xaxis.color": ink, "scene.yaxis.color": ink, "scene.zaxis.color": ink }
        : { "font.color": ink, "xaxis.gridcolor": lines, "yaxis.gridcolor": lines };
      Plotly.relayout(box, change);
    }
  };
  dark.addEventListener("change", repaint);
  printing.addEventListener("change", repaint);
  addEventListener("beforeprint", () => { for (const box of boxes) if (box.classList.contains("plot")) draw(box); });
  document.documentElement.dataset.ready = String(Math.round(performance.now()));
})();
