// On paper: the picture with its names as one canvas, in light colours, as large as the paper allows.
const root = document.documentElement;

/** Put the picture of the stage on paper while the page is printed. */
export function printPicture(stage, display) {
  let printed = null;
  let theme = null;
  window.addEventListener("beforeprint", () => {
    if (printed) return;
    theme = root.dataset.theme;
    display.theme("light");
    printed = stage.copy();
    printed.id = "printed";
    stage.canvas.after(printed);
  });
  window.addEventListener("afterprint", () => {
    printed?.remove();
    printed = null;
    display.theme(theme);
  });
}
