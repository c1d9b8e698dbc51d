// Which elements are on the screen, without a layout for each frame.

/**
 * Return a function that returns whether an element is on the screen.
 * @param {Element} element
 */
export function whetherSeen(element) {
  let seen = true;
  const observer = new IntersectionObserver((entries) => { seen = entries[entries.length - 1].isIntersecting; });
  observer.observe(element);
  return { isSeen: () => seen, end: () => observer.disconnect() };
}
