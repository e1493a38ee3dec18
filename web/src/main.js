// Entry: the page is complete without scripts; they add values under the pointer and the 3-D view.
import {show_values} from './hover.js';
import {start_view} from './view3d.js';

for (const plot of document.querySelectorAll('svg.plot[data-scale]')) show_values(plot);
const holder = document.getElementById('view3d');
if (holder) start_view(holder);
document.documentElement.dataset.scripts = 'done';
