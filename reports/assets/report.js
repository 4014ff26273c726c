// Filters the table of cases; without scripts the whole table is shown and no filter.
(function () {
  var bar = document.querySelector('.filters');
  if (!bar) { return; }
  var box = bar.querySelector('input');
  var buttons = bar.querySelectorAll('button');
  var cases = document.querySelectorAll('table.cases tbody');
  var none = document.querySelector('.none');
  var wanted = '';
  function apply() {
    var words = box.value.toLowerCase().split(/\s+/);
    var shown = 0;
    cases.forEach(function (body) {
      var text = body.textContent.toLowerCase();
      var fits = (!wanted || body.dataset.status === wanted) &&
        words.every(function (word) { return text.indexOf(word) >= 0; });
      body.hidden = !fits;
      shown += fits ? 1 : 0;
    });
    none.hidden = shown > 0;
    buttons.forEach(function (button) {
      button.setAttribute('aria-pressed', String(button.dataset.status === wanted));
    });
  }
  box.addEventListener('input', apply);
  buttons.forEach(function (button) {
    button.addEventListener('click', function () { wanted = button.dataset.status; apply(); });
  });
  bar.hidden = false;
  // Paper cannot be unfolded.
  window.addEventListener('beforeprint', function () {
    document.querySelectorAll('article details').forEach(function (each) { each.open = true; });
  });
})();
