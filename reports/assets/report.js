// Filter of the table of cases; without scripts the whole table is shown.
(function () {
  var box = document.querySelector('.filters input');
  if (!box) { return; }
  var buttons = document.querySelectorAll('.filters button');
  var rows = document.querySelectorAll('table.cases tbody tr');
  var wanted = '';
  function apply() {
    var words = box.value.toLowerCase();
    rows.forEach(function (row) {
      var text = row.textContent.toLowerCase();
      row.hidden = (wanted && row.dataset.status !== wanted) || text.indexOf(words) < 0;
    });
    buttons.forEach(function (button) {
      button.setAttribute('aria-pressed', button.dataset.status === wanted);
    });
  }
  box.addEventListener('input', apply);
  buttons.forEach(function (button) {
    button.addEventListener('click', function () { wanted = button.dataset.status; apply(); });
  });
})();
