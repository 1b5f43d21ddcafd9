import { make } from './lab.js';

const main = document.querySelector('main');
const list = await (await fetch('pages.json')).json();
main.append(
  make('h1', {}, 'The lectures alive'),
  make('p', {}, 'Every applet of four lectures on texture mapping, drawn in this page by texmap on one core of this machine. Pictures have the bytes that the native program draws; nothing is sent anywhere.'),
  make('ul', { class: 'cards' }, ...list.map(({ name, title, slide }) => make('li', {}, make('a', { href: `${name}.html` }, make('b', {}, title), make('small', {}, slide))))),
);
main.dataset.state = 'ready';
