// Whether an element is on the screen, without a layout for each frame.

/**
 * Observe an element; return the functions that report whether it is on the screen, and that end the observation.
 * @param {Element} element
 */
export function observeVisibility(element) {
  let seen = true;
  const observer = new IntersectionObserver((entries) => { seen = entries[entries.length - 1].isIntersecting; });
  observer.observe(element);
  return { isSeen: () => seen, end: () => observer.disconnect() };
}
