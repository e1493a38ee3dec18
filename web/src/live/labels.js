// Words that stand at places of the 3-D view.

const RANKS = ['vehicle', 'lost', 'link', 'goal', 'range'];

const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

export class Labels {
  constructor(holder, view) {
    this.holder = holder;
    this.view = view;
    this.shown = new Map();
    view.drawn.push(() => this.place());
  }

  /** @param labels list of {key, place, text, note, kind, colour} */
  set(labels) {
    const wanted = new Set(labels.map((l) => l.key));
    for (const [key, {element}] of this.shown) {
      if (wanted.has(key)) continue;
      element.remove();
      this.shown.delete(key);
    }
    for (const label of labels) {
      let entry = this.shown.get(label.key);
      if (!entry) {
        const element = document.createElement('div');
        element.append(document.createElement('b'), document.createElement('span'));
        this.holder.append(element);
        entry = {element};
        this.shown.set(label.key, entry);
      }
      entry.place = label.place;
      entry.element.className = `label ${label.kind}`;
      entry.element.style.setProperty('--colour', label.colour ?? '#fff');
      entry.element.firstChild.textContent = label.text ?? '';
      entry.element.lastChild.textContent = label.note ?? '';
      entry.rank = Math.max(RANKS.indexOf(label.kind.split(' ')[0]), 0);
      [entry.width, entry.height] = [entry.element.offsetWidth, entry.element.offsetHeight];
    }
    this.place();
  }

  /** Where labels would lie on each other, those of vehicles stay. */
  place() {
    const taken = [];
    for (const entry of [...this.shown.values()].sort((a, b) => a.rank - b.rank)) {
      const at = this.view.pixel_of(entry.place);
      const box = at && {x: at[0] - entry.width / 2, y: at[1] - entry.height, width: entry.width, height: entry.height};
      const shown = box && (entry.rank === 0 || !taken.some((other) => overlap(box, other)));
      entry.element.style.visibility = shown ? 'visible' : 'hidden';
      if (!shown) continue;
      taken.push(box);
      entry.element.style.transform = `translate(${box.x.toFixed(1)}px, ${box.y.toFixed(1)}px)`;
    }
  }
}
