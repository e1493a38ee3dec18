// Elements in one call. Text from outside is only ever set as text.

export function el(tag, kind, ...children) {
  const element = document.createElement(tag);
  if (kind) element.className = kind;
  element.append(...children.filter((child) => child !== null && child !== undefined && child !== ''));
  return element;
}

export const by_id = (id) => document.getElementById(id);

/** Rows of cells as a table; the first row is its head. */
export function table(head, rows) {
  const row = (cells, tag) => el('tr', '', ...cells.map((cell) => el(tag, cell?.kind ?? '', cell?.text ?? cell)));
  return el('table', '', el('thead', '', row(head, 'th')), el('tbody', '', ...rows.map((cells) => row(cells, 'td'))));
}
