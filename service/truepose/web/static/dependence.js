// How much of the variance of errors follows a variable, whatever the shape: readings in classes of equal counts.
// Epsilon squared (Kelley, 1935) corrects what as many classes would show by chance; it is 0 where nothing depends.

const CLASSES = 12;
const FEWEST = 5; // readings of a class

export function dependence(values, errors) {
  const known = [...values.keys()].filter((i) => !Number.isNaN(values[i])).sort((a, b) => values[a] - values[b]);
  const n = known.length;
  const classes = Math.min(CLASSES, Math.floor(n / FEWEST));
  if (classes < 2 || values[known[0]] === values[known[n - 1]]) return 0;
  const mean = known.reduce((sum, i) => sum + errors[i], 0) / n;
  const total = known.reduce((sum, i) => sum + (errors[i] - mean) ** 2, 0);
  if (total === 0) return 0;
  const groups = grouped(known, values, n / classes);
  const within = groups.reduce((sum, group) => sum + spread(group, errors), 0);
  return groups.length < 2 ? 0 : Math.max(0, 1 - (within / (n - groups.length)) / (total / (n - 1)));
}

// Equal values stay together: an attachment is one class, however many readings it has.
function grouped(order, values, size) {
  const groups = [[]];
  for (const i of order) {
    const last = groups[groups.length - 1];
    if (last.length >= size && values[i] !== values[last[last.length - 1]]) groups.push([i]);
    else last.push(i);
  }
  return groups;
}

function spread(group, errors) {
  const mean = group.reduce((sum, i) => sum + errors[i], 0) / group.length;
  return group.reduce((sum, i) => sum + (errors[i] - mean) ** 2, 0);
}
