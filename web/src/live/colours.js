// Colours that remain apart for any colour vision (Okabe and Ito), on dark and on light ground.

const VEHICLES = ['#56b4e9', '#e69f00', '#00b88a', '#cc79a7', '#f0e442', '#d55e00', '#8f8cf2', '#b0b7c3'];

export const vehicle_colour = (index) => VEHICLES[index % VEHICLES.length];

export const DEGENERATE = '#ff7a1a';
export const FRONTIER = '#f0e442';
export const RANGE = '#4fd8ff';
export const RANGE_UNUSED = '#8b93a1';

/** Good, worse, lost. */
export function link_colour(link) {
  if (!link.connected) return '#e5484d';
  if (link.loss > 0.3) return '#f76b15';
  return link.loss > 0.1 ? '#f5c518' : '#46c37b';
}

/** Heights from low to high; floors are dark, so that what stands on them is seen. */
export const HEIGHTS = ['#2c4a78', '#2f86b0', '#57bfa6', '#bfdc8c', '#fbf3c4'];
