package ssv.spy;

import info.monitorenter.gui.chart.Chart2D;
import info.monitorenter.gui.chart.ITrace2D;
import info.monitorenter.gui.chart.traces.Trace2DSimple;
import info.monitorenter.util.Range;
import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.GridLayout;
import java.util.Locale;
import javax.swing.BorderFactory;
import javax.swing.JComponent;
import javax.swing.JPanel;
import javax.swing.JSplitPane;
import javax.swing.JTextArea;
import ssv.answer_t;
import ssv.plan_t;
import ssv.quote_t;
import ssv.segment_t;

/** A plan: its price in words, six thrusts over time, and the way from above. */
final class PlanView implements Window.View<plan_t> {
    private static final int THRUSTERS = 6;
    private static final String[] STATUS = {"ok", "infeasible", "invalid", "numeric overflow"};

    private final JPanel panel = new JPanel(new BorderLayout());
    private final JTextArea words = new JTextArea(2, 40);
    private final TopView way = new TopView();
    private final ITrace2D[] thrust = new ITrace2D[THRUSTERS];
    private final Chart2D[] chart = new Chart2D[THRUSTERS];

    PlanView() {
        JPanel charts = new JPanel(new GridLayout(THRUSTERS, 1));
        for (int i = 0; i < THRUSTERS; i++) {
            thrust[i] = new Trace2DSimple("T" + (i + 1));
            thrust[i].setColor(Chart.INK);
            chart[i] = Chart.of("thrust " + (i + 1), i + 1 < THRUSTERS ? "" : "t [s]", "T" + (i + 1) + " [N]", thrust[i]);
            charts.add(chart[i]);
        }
        words.setName("words");
        words.setEditable(false);
        words.setLineWrap(true);
        words.setWrapStyleWord(true);
        words.setBorder(BorderFactory.createEmptyBorder(6, 8, 6, 8));
        JSplitPane both = new JSplitPane(JSplitPane.HORIZONTAL_SPLIT, charts, way);
        both.setResizeWeight(0.5);
        both.setDividerLocation(550);
        panel.setBackground(Color.WHITE);
        panel.add(words, BorderLayout.NORTH);
        panel.add(both, BorderLayout.CENTER);
    }

    @Override
    public JComponent component() {
        return panel;
    }

    @Override
    public void show(plan_t plan) {
        words.setText(inWords(plan));
        way.show(plan);
        double most_N = 0.1, last_s = 1;
        for (int i = 0; i < THRUSTERS; i++) {
            thrust[i].removeAllPoints();
            for (segment_t segment : plan.segments) {
                Chart.add(thrust[i], segment.t_s, segment.u_start_N[i]);
                Chart.add(thrust[i], segment.t_s + segment.duration_s, segment.u_end_N[i]);
            }
            most_N = Math.max(most_N, Math.max(-thrust[i].getMinY(), thrust[i].getMaxY()));
            last_s = Math.max(last_s, thrust[i].getMaxX());
        }
        for (Chart2D one : chart) {
            Chart.scale(one, new Range(0, last_s), new Range(-1.1 * most_N, 1.1 * most_N));
        }
    }

    private static String inWords(plan_t plan) {
        quote_t quote = plan.quote;
        answer_t answer = plan.answer;
        String whose = String.format(Locale.ROOT, "%nPlan %016x of planner %016x, which answers request %016x of asker %016x.", plan.plan_hash,
            answer.planner.planner_id, answer.asker.request_id, answer.asker.asker_id);
        if (quote.status != quote_t.STATUS_OK) {
            String status = quote.status >= 0 && quote.status < STATUS.length ? STATUS[quote.status] : "status " + quote.status;
            return "No plan, " + status + ": " + quote.reason + whose;
        }
        return String.format(Locale.ROOT, "J = %.3f (none below %.3f): %.3f s, %.3f N s; mates at height %+.4f m, contact %d docks; %d legs, %d segments.",
            quote.cost, quote.cost_lower_bound, quote.time_s, quote.impulse_Ns, quote.choice.attach_height_m, quote.choice.contact,
            plan.num_legs, plan.num_segments) + whose;
    }
}
