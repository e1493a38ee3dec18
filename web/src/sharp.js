// Loaded before uPlot, which reads this once: drawings get twice the pixels of a plain screen, since
// paper has more.
const pixels = Math.max(2, window.devicePixelRatio || 1);
Object.defineProperty(window, 'devicePixelRatio', {get: () => pixels});
