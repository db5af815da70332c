// SPDX-License-Identifier: BSD-3-Clause
function dataOf(name) {
  const block = document.getElementById(name + "-data");
  return block ? JSON.parse(block.textContent) : null;
}

function start() {
  const charts = dataOf("charts") || [];
  const curves = document.getElementById("curves");
  curves.hidden = !charts.length;
  Scene.charts = charts.map((spec) => new Chart(curves, {...spec, followsTime: !spec.label}))
    .filter((chart) => chart.spec.followsTime);
  const residuals = dataOf("residuals");
  if (residuals && residuals.tries.length) new Residuals(document.getElementById("residuals"), residuals);
  const scene = dataOf("scene");
  if (scene) new Scene(document.getElementById("scene"), scene);
  for (const button of document.querySelectorAll("button.save")) {
    button.onclick = (event) => {
      event.preventDefault();
      const text = button.closest("details").querySelector("pre").textContent;
      save(button.dataset.file.split("/").pop(), text + "\n");
    };
  }
  document.body.dataset.ready = "yes";
}
start();
