"use strict";
// Texts of students reach the page as text nodes only, never as HTML.

const all = (what, within = document) => [...within.querySelectorAll(what)];
const byId = id => document.getElementById(id);
const countOf = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

function makeButton(label, act) {
  const button = make("button", {type: "button"}, label);
  button.addEventListener("click", act);
  return button;
}

document.documentElement.classList.add("js");

// --- the tables: a click on a column head sorts ---

function sortKey(row, column) {
  const cell = row.cells[column];
  return cell.dataset.value ?? cell.textContent.trim().replace("−", "-").replace(/^–$/, "");
}

function sortBy(table, heads, column) {
  const up = heads[column].getAttribute("aria-sort") !== "ascending";
  heads.forEach(head => head.removeAttribute("aria-sort"));
  heads[column].setAttribute("aria-sort", up ? "ascending" : "descending");
  const body = table.tBodies[0];
  const filled = [...body.rows].filter(row => sortKey(row, column) !== "");
  const blank = [...body.rows].filter(row => sortKey(row, column) === "");
  const numbers = filled.every(row => !Number.isNaN(Number(sortKey(row, column))));
  filled.sort((p, q) => numbers
    ? sortKey(p, column) - sortKey(q, column)
    : sortKey(p, column).localeCompare(sortKey(q, column), "en"));
  body.append(...(up ? filled : filled.reverse()), ...blank);
}

for (const table of all("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    head.replaceChildren(makeButton(head.textContent, () => sortBy(table, heads, column)));
  });
}

// --- the filter: what is said of a student anywhere finds the student everywhere ---

const bar = all(".filter")[0];
const [searchBox, sectionChoice, counts] = all("input, select, output", bar);
const groups = all(".group");
const plain = text => text.toLowerCase().normalize("NFD").replace(/\p{M}/gu, "");

const items = all("[data-f]").map(item => {
  const isQuestion = "offer" in item.dataset;
  const parts = isQuestion ? [all(".k", item)[0], all(".k", item.closest(".group"))[0]] : [item];
  return {
    item,
    text: plain(parts.map(part => part.textContent).join(" ")),
    isRow: item.matches("tr"),
    isQuestion,
    places: all(".k a, th a", item).map(link => link.dataset.student),
    sections: all(".sec", item).map(part => part.textContent),
  };
});
const textOfQuestions = new Map();
for (const {isQuestion, places, text} of items) {
  if (!isQuestion) continue;
  for (const place of places) textOfQuestions.set(place, `${textOfQuestions.get(place) ?? ""} ${text}`);
}
for (const one of items) if (one.isRow) one.text += textOfQuestions.get(one.places[0]) ?? "";

function filter() {
  const words = plain(searchBox.value).split(/\s+/);
  const section = sectionChoice.value;
  let questions = 0, rows = 0;
  for (const {item, text, isRow, isQuestion, sections} of items) {
    const matches = words.every(word => text.includes(word));
    item.hidden = !matches || (section !== "" && !sections.includes(section));
    if (item.hidden) continue;
    questions += isQuestion;
    rows += isRow;
  }
  for (const group of groups) {
    const count = all("[data-f]:not([hidden])", group).length;
    group.hidden = !count;
    all(".count", group)[0].textContent = count;
  }
  counts.textContent = `${questions} for you to decide, ${rows} of ${items.filter(one => one.isRow).length} students`;
}

const sections = [...new Set(items.flatMap(one => one.sections))].filter(Boolean);
sections.sort((p, q) => p.localeCompare(q, "en", {numeric: true}));
sectionChoice.append(...sections.map(section => new Option(section)));
sectionChoice.parentElement.hidden = !sections.length;
bar.hidden = false;
bar.addEventListener("submit", event => event.preventDefault());
bar.addEventListener("input", filter);
filter();

// --- the lines of desk.csv, as they are now on this page ---

const data = JSON.parse(byId("data").textContent);
const words = new Map(data.words.map(word => [word.what, word]));
const students = new Map(data.students.map(student => [student.id, student]));
const formula = /(^(?=[\s"]*[=+\-@＝＋－＠])|[;\n\t](?=(?:[^\S\n]|")*[=+\-@＝＋－＠]))|^(?=[\t\n])/g;
const formulaMark = /(^|[;\n\t])'(?=[\s"]*[=+\-@＝＋－＠])/g;
let lines = data.desk;
let unsaved = 0;

const isSame = (some, others) => some.length === others.length && some.every(one => others.includes(one));
const isAbout = (line, people, what) => line.what === what && isSame(line.people, people);

function csvCell(text) {
  const cell = text.replace(/\r\n?/g, "\n").trim().replace(formula, "$1'");
  return /^[\w.-]*$/.test(cell) ? cell : `"${cell.replaceAll('"', '""')}"`;
}

function deskCsv() {
  const rows = lines.map(line => data.columns.map(column => csvCell(line.cells[column] ?? "")));
  // Spreadsheets need the first sign to read "±".
  return `\ufeff${[data.columns, ...rows].map(row => `${row.join(",")}\n`).join("")}`;
}

function csvTable(text) {
  const head = text.split("\n", 1)[0];
  const count = sign => head.split(sign).length;
  const delimiter = [",", ";", "\t"].reduce((best, sign) => count(sign) > count(best) ? sign : best);
  const table = [[""]];
  let quoted = false;
  for (let at = 0; at < text.length; at++) {
    const sign = text[at], row = table.at(-1), last = row.length - 1;
    if (quoted && sign === '"' && text[at + 1] === '"') {
      row[last] += sign;
      at++;
    } else if (sign === '"' && (quoted || row[last].trim() === "")) {
      quoted = !quoted;
    } else if (sign === delimiter && !quoted) {
      row.push("");
    } else if (sign === "\n" && !quoted) {
      table.push([""]);
    } else {
      row[last] += sign;
    }
  }
  return table.map(row => row.map(cell => cell.trim().replace(formulaMark, "$1")));
}

// Lines of the file replace those of the page that nobody has changed here.
function readDesk(text) {
  const [head, ...rows] = csvTable(text.replace(/^\ufeff/, "").replace(/\r\n?/g, "\n"));
  const columns = head.map(title => title.toLowerCase());
  if (!["student", "what", "value"].every(column => columns.includes(column))) return null;
  data.columns.push(...columns.filter(column => column && !data.columns.includes(column)));
  const read = rows.filter(row => row.some(Boolean)).map(row => {
    const cells = Object.fromEntries(columns.map((column, at) => [column, row[at] ?? ""]));
    const written = cells.student;
    const people = students.has(written) ? [written] : written.split(" + ");
    const what = words.has(cells.what) ? cells.what : cells.what.toLowerCase();
    return {people, what, cells, isNew: true};
  });
  const isOf = (some, line) => some.some(one => isAbout(one, line.people, line.what));
  const changed = lines.filter(line => line.isNew);
  const added = read.filter(line => words.get(line.what)?.is_several
    ? !lines.some(one => isAbout(one, line.people, line.what) && one.cells.value === line.cells.value)
    : !isOf(changed, line));
  const replaced = added.filter(line => !words.get(line.what)?.is_several);
  lines = [...lines.filter(line => !isOf(replaced, line)), ...added];
  return added.length;
}

// --- one student after the other ---

const review = byId("review");
const graderName = byId("by");
let current = null;

function tell(text) {
  byId("told").textContent = text;
}

function isOpen(offer) {
  const settles = line => offer.settled_by.length
    ? offer.settled_by.includes(line.what)
    : !["comment", "regrade", "flag"].includes(line.what);
  const isFlag = offer.what === "flag";
  return !lines.some(line => line.isNew && settles(line)
    && (isFlag ? isSame(line.people, offer.people) : line.people.includes(offer.people[0]))
    && (offer.what !== "regrade" || line.cells.why === offer.why));
}

const openOffers = student => data.offers.filter(one => one.people.includes(student.id) && isOpen(one));

// The students of the table, in its order, without those that the filter hides.
function listed() {
  const links = all("table.everybody tbody tr:not([hidden]) th a");
  return links.map(link => data.students[link.dataset.student]);
}

function decide(people, what, value, why) {
  const by = graderName.value.trim();
  const word = words.get(what);
  if (!by) {
    tell("First write your name: it is kept with each decision.");
    graderName.focus();
    return;
  }
  const questions = openOffers(current).length;
  const isOld = line => isAbout(line, people, what)
    && (!word.is_several || (what === "regrade" && !line.cells.value && line.cells.why === why));
  const old = lines.find(isOld);
  const before = old?.cells ?? {student: people.join(" + "), what};
  // A line that is written again confirms what it says for another submission.
  const isAgain = old && before.value === value && before.by === by && before.why === why;
  const cells = {...before, value, by, why: isAgain ? `${why} (confirmed)` : why};
  lines = [...lines.filter(line => !isOld(line)), {people, what, cells, isNew: true}];
  unsaved += 1;
  tell(`Decided for ${people.map(id => students.get(id)?.name ?? id).join(" and ")}: ${what} ${value}`);
  const left = openOffers(current).length;
  // Who answers the last question of a student goes on to the next student.
  if (left || left === questions || !goOpen()) show(current, left < questions ? "question" : "");
}

function remove(line) {
  lines = lines.filter(one => one !== line);
  unsaved += 1;
  tell("The line is removed.");
  show(current);
}

// The field of a value, as its kind needs it.
function valueField(word, value) {
  const criterion = data.criteria.find(one => one.what === word.what);
  const name = word.what === "regrade" ? "answer" : criterion?.title ?? word.what;
  const label = make("label", {}, `${name} `);
  let field = null;
  if (word.kind === "text") {
    field = make("textarea", {rows: 2});
  } else if (word.kind === "student") {
    field = make("select", {}, ...data.students.map(one => new Option(one.name, one.id)));
  } else if (word.kind === "verdict") {
    field = make("select", {}, ...data.verdicts.map(verdict => new Option(verdict)));
  } else if (word.kind !== "nothing") {
    field = make("input", {autocomplete: "off", placeholder: word.kind === "inertia" ? "4.4e-3 ± 0.1e-3" : ""});
    if (word.kind === "points") label.append(`(0 to ${word.most}) `);
    if (word.kind === "inertia") label.append("(in kg m^2, or with another unit) ");
  }
  if (!field) return [null, null];
  field.value = value || field.value;
  label.append(field);
  return [label, field];
}

function problemOf(word, value) {
  const number = Number(value.replace(",", "."));
  if (!value && word.kind !== "nothing") return "Write a value.";
  if (word.kind === "points" && !(number >= 0 && number <= word.most && /^\d|^\./.test(value))) return word.how;
  if (word.kind === "number" && Number.isNaN(number)) return word.how;
  if (word.kind === "inertia" && !/\d/.test(value)) return word.how;
  return "";
}

// A form for one word; `offer` is the question that it answers, if there is one.
function decisionForm(people, word, offer = {}) {
  const [label, field] = valueField(word, offer.value);
  const why = make("input", {class: "why", autocomplete: "off"});
  // The request of a student stays as it is; what gyro asks is not for the student.
  const isRequest = offer.what === "regrade";
  why.value = isRequest ? offer.why : "";
  why.readOnly = isRequest;
  const whyLabel = make("label", {}, isRequest ? "request " : "why ", why);
  const form = make("form", {class: "decision"}, label ?? `${word.title}. `, whyLabel);
  form.append(make("button", {}, "Decide"));
  if (offer.leave) {
    form.append(makeButton("Keep gyro's result", () => decide(people, word.what, "", why.value.trim())));
  }
  form.addEventListener("submit", event => {
    event.preventDefault();
    const value = field ? field.value.trim() : "";
    const problem = problemOf(word, value);
    if (problem) {
      tell(problem);
      field.setAttribute("aria-invalid", "true");
      field.focus();
    } else {
      const lacksUnit = word.kind === "inertia" && /^[-\d.,eE+±()\s]*$/.test(value);
      decide(people, word.what, lacksUnit ? `${value} kg m^2` : value, why.value.trim());
    }
  });
  return form;
}

function flagForm(offer) {
  const why = make("input", {class: "why", autocomplete: "off"});
  const isAlone = offer.people.length + offer.earlier.length < 2;
  const verdicts = data.verdicts.filter(verdict => !(isAlone && ["partners", "copied"].includes(verdict)));
  const buttons = verdicts.map(verdict =>
    makeButton(verdict, () => decide(offer.people, "flag", verdict, why.value.trim())));
  why.addEventListener("keydown", event => {
    if (event.key === "Enter") tell(`Press one of the buttons: ${verdicts.join(", ")}.`);
  });
  return make("p", {class: "decision"}, make("label", {}, "why ", why), ...buttons);
}

function table(label, heads, rows) {
  const cells = (row, tag) => row.map(text => make(tag, tag === "th" ? {scope: "col"} : {}, text));
  const head = make("thead", {}, make("tr", {}, ...cells(heads, "th")));
  const body = make("tbody", {}, ...rows.map(row => make("tr", {}, ...cells(row, "td"))));
  const box = make("div", {class: "box", role: "region", "aria-label": label, tabindex: 0});
  box.append(make("table", {}, head, body));
  return box;
}

// --- copies, side by side ---

const difference = (row, other) => Math.max(
  ...[1, 2, 3].map(at => Math.abs(Math.log(Math.abs(row[at] / other[at])))).map(one => Number.isNaN(one) ? 0 : one));

function nearestRow(row, left) {
  const near = left.reduce((best, other) => difference(row, other) < difference(row, best) ? other : best, left[0]);
  return near && difference(row, near) < 0.3 ? near : null;
}

function sideBySide(student, other) {
  const left = [...other.rows];
  const rows = student.rows.map(row => {
    const near = nearestRow(row, left);
    if (near) left.splice(left.indexOf(near), 1);
    const pair = [0, 2, 3].flatMap(at => [row[at], near ? near[at] : "–"]);
    return pair.map((text, at) => at > 1 && pair[at] === pair[at ^ 1] ? make("mark", {}, text) : text);
  });
  const heads = ["A line", "B line", "A rpm", "B rpm", "A time [s]", "B time [s]"];
  const names = make("p", {class: "soft"}, `A: ${student.name}, B: ${other.name}`);
  return [names, table(`${student.name} beside ${other.name}`, heads, rows)];
}

// --- the parts of the view ---

function questionPart(student) {
  return openOffers(student).map(offer => {
    const part = make("div", {class: "flag question"}, make("p", {}, offer.why));
    if (offer.what !== "flag") {
      part.append(decisionForm(offer.people, words.get(offer.what), offer));
      return part;
    }
    const others = offer.people.filter(id => id !== student.id).map(id => students.get(id)).filter(Boolean);
    part.append(flagForm(offer), ...others.slice(0, 3).flatMap(other => sideBySide(student, other)));
    if (others.length > 3) part.append(make("p", {}, `and ${others.length - 3} more students`));
    if (offer.earlier.length) part.append(make("p", {}, `Earlier logs: ${offer.earlier.join(", ")}`));
    return part;
  });
}

function pointsPart(student) {
  const rows = data.criteria.map((criterion, at) => {
    const [points, reason] = student.marks[at];
    const change = makeButton("change", () => choose(criterion.what, points));
    change.setAttribute("aria-label", `change the points of ${criterion.title}`);
    return [criterion.title, `${points} of ${criterion.of}`, reason, change];
  });
  return table("Points", ["criterion", "points", "what was found", ""], rows);
}

function linesPart(student) {
  const mine = lines.filter(line => line.people.includes(student.id));
  const entries = mine.map(line => {
    const {what, value, by, why} = line.cells;
    return make("li", {}, `${what} ${value}`, ...(why ? [`: ${why}`] : []), ...(by ? [` (${by}) `] : [" "]),
      makeButton("remove", () => remove(line)));
  });
  return entries.length ? [make("h3", {}, "Lines in desk.csv"), make("ul", {}, ...entries)] : [];
}

function answerPart(student) {
  const [text, place] = student.answer;
  const parts = [make("h3", {}, "The answer")];
  parts.push(text ? make("p", {}, make("strong", {}, text), place ? ` – ${place}` : "")
    : make("p", {}, "No I_zz is reported."));
  if (student.own) parts.push(make("p", {}, `The own runs give ${student.own}.`));
  return parts;
}

function logPart(student) {
  const rows = [...student.rows].sort((p, q) => p[0] - q[0]);
  const parts = [make("h3", {}, "The log as read")];
  const links = student.files.map(([name, href]) => href ? make("a", {href}, name) : name);
  parts.push(make("p", {}, ...links.flatMap((link, at) => at ? [", ", link] : [link])));
  if (student.notes.length) parts.push(make("ul", {}, ...student.notes.map(note => make("li", {}, note))));
  if (rows.length) parts.push(table("Runs", ["line", "torque [mN·m]", "spin [rpm]", "time [s]", "turns"], rows));
  return parts;
}

// Another decision: the form follows the chosen word.
function choose(what, value = "") {
  byId("what").value = what;
  const form = decisionForm([current.id], words.get(what), {value});
  byId("other").replaceChildren(form);
  all("input, textarea, select, button", form)[0].focus();
}

const questionField = () =>
  all("#questions input, #questions textarea, #questions select, #questions button")[0] ?? byId("who");

function show(student, focus = "") {
  current = student;
  review.hidden = false;
  const places = listed();
  byId("who").textContent = student.name;
  byId("place").textContent = `${places.indexOf(student) + 1} of ${places.length}; ${countOf(data.offers.filter(isOpen).length, "open question")}; ${countOf(unsaved, "change")} to save`;
  byId("about").replaceChildren(student.about.join("; "));
  if (student.feedback) byId("about").append("; ", make("a", {href: student.feedback}, "feedback"));
  if (student.group.length) byId("about").append(`; works with ${student.group.join(", ")}`);
  byId("questions").replaceChildren(...questionPart(student));
  byId("points").replaceChildren(make("h3", {}, "The points"), pointsPart(student));
  byId("lines").replaceChildren(...linesPart(student));
  byId("other").replaceChildren();
  byId("what").value = "";
  byId("answer").replaceChildren(...answerPart(student), ...logPart(student));
  markOpen();
  if (focus !== "none") (focus === "question" ? questionField() : byId("who")).focus();
}

function markOpen() {
  for (const item of all("[data-offer]")) item.classList.toggle("done", !isOpen(data.offers[item.dataset.offer]));
}

function go(step) {
  const places = listed();
  const at = places.indexOf(current) + step;
  if (places[at]) show(places[at]);
  else tell(step > 0 ? "This is the last student." : "This is the first student.");
}

// The next student with an open question, from the beginning after the last one.
function goOpen() {
  const places = listed();
  const at = places.indexOf(current) + 1;
  const next = [...places.slice(at), ...places.slice(0, at)].find(student => openOffers(student).length);
  if (next) show(next, "question");
  else tell("No question is open among the listed students: save desk.csv.");
  return Boolean(next);
}

function save() {
  const file = new Blob([deskCsv()], {type: "text/csv"});
  const link = make("a", {href: URL.createObjectURL(file), download: "desk.csv"});
  unsaved = 0;
  link.click();
  show(current, "none");
  tell("Put the file into the folder of this page with the name desk.csv, and run gyro again.");
}

async function read(event) {
  const [file] = event.target.files;
  if (!file) return;
  const count = readDesk(await file.text());
  if (count === null) {
    tell("This file has no columns student, what and value.");
    return;
  }
  unsaved += count;
  show(current);
  tell(`Added: ${countOf(count, "line")}.`);
}

function onKey(event) {
  const isTyping = event.target.matches("input, textarea, select");
  const isNamed = event.key === "Enter" && event.target === graderName;
  const isLeft = event.key === "Escape" && isTyping && !event.target.matches("[type=search]");
  if (isLeft) byId("who").focus();
  if (isNamed) {
    // The same Enter does not send the form of the question.
    event.preventDefault();
    tell("");
    if (openOffers(current).length) questionField().focus();
    else goOpen();
  }
  if (isTyping || event.ctrlKey || event.metaKey || event.altKey || !current) return;
  const acts = {n: () => go(1), p: () => go(-1), o: goOpen};
  if (!acts[event.key]) return;
  event.preventDefault();
  acts[event.key]();
}

byId("previous").addEventListener("click", () => go(-1));
byId("next").addEventListener("click", () => go(1));
byId("open").addEventListener("click", goOpen);
byId("save").addEventListener("click", save);
byId("read").addEventListener("change", read);
byId("what").append(new Option("choose …", ""), ...data.words.map(word => new Option(`${word.what}: ${word.title}`, word.what)));
byId("what").addEventListener("change", event => event.target.value && choose(event.target.value));
document.addEventListener("keydown", onKey);
// A name in a list or a table shows the student here.
for (const link of all("[data-student]")) link.href = "#review";
document.addEventListener("click", event => {
  const link = event.target.closest("[data-student]");
  if (!link) return;
  event.preventDefault();
  show(data.students[link.dataset.student]);
});
const first = data.students.find(student => openOffers(student).length) ?? data.students[0];
if (first) show(first, "none");
window.addEventListener("beforeunload", event => unsaved && event.preventDefault());
