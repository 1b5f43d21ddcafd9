import { make, tell } from './lab.js';

const main = document.querySelector('main');
const words = make('p', {});
const list = await fetch('pages.json').then((answer) => answer.json()).catch(() => {
  tell(words, new Error('the list of pages cannot be loaded: reload the page'));
  return [];
});
main.append(
  make('h1', {}, 'The lectures alive'),
  make('p', {}, 'Every applet of four lectures on texture mapping, drawn in this page by texmap on one core of this machine. Pictures have the bytes that the native program draws; nothing is sent anywhere.'),
  words,
  make('ul', { class: 'cards' }, ...list.map(({ name, title, slide }) => make('li', {}, make('a', { href: `${name}.html` }, make('b', {}, title), make('small', {}, slide))))),
);
main.dataset.state = 'ready';
