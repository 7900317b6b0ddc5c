// Colours of the page, by name.

export const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
