// Words that stand at places of the 3-D view.

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
    }
    this.place();
  }

  place() {
    for (const {element, place} of this.shown.values()) {
      const at = this.view.pixel_of(place);
      element.hidden = at === null;
      if (at) element.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px)`;
    }
  }
}
