// Whose name a cell takes: where it announces people one of theirs, else every name. Pure.

// As the service compares names: composed characters, single blanks, capitals do not matter.
const tidy = (name) => name.normalize("NFC").trim().replace(/ {2,}/g, " ").toLowerCase();

export const same = (one, other) => one !== null && tidy(one) === tidy(other);

export function isTaken(name, people) {
  return Boolean(name) && (!people.length || people.some((person) => same(name, person)));
}
